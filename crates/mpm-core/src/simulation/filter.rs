//! XPIC's passes: what the grid does not yet return to the particles is given to it again; see [`Transfer`](crate::Transfer).

use super::Simulation;
use crate::body::StepSettings;
use crate::grid::Addition;
use mechanics_core::lanes::Element;

impl<E: Element, const D: usize> Simulation<E, D> {
    /// Makes the momenta of the nodes those of v*, where the transfer takes more than one pass; answers what is left to add.
    pub(super) fn filter(&mut self, settings: &StepSettings) -> Addition {
        let passes = settings.transfer.passes();
        if passes == 0 {
            return Addition::Fresh;
        }
        self.add_arenas(Addition::Fresh);
        let stride = self.grid.arena_stride();
        for _ in 0..passes {
            let mut first = 0;
            for body in &self.bodies {
                let count = body.particles.blocks.len();
                let arenas = &mut self.arenas[first * stride..(first + count) * stride];
                body.correct(arenas, &self.grid, first, settings);
                first += count;
            }
            self.add_arenas(Addition::Momentum);
        }
        Addition::Nothing
    }

    fn add_arenas(&mut self, addition: Addition) {
        self.grid.collect(&self.arenas, addition, &mut self.results, |_, _, _, _| {});
    }
}
