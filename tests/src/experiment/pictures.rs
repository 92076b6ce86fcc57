//! Pictures and films of a row, in the folder that the suite keeps for them.

use super::{ExperimentError, Outcome, Point};
use crate::picture::{Chart, Film, Image, Size, draw_chart};
use crate::record::Picture;
use crate::report::text::{shortest, significant};

impl Point<'_> {
    /// What tells this row from others: the method and the ladder's value.
    pub(crate) fn title(&self) -> String {
        let ladder = self.scene.validation.as_ref().map(|validation| &validation.ladder);
        let (name, unit) = ladder.map_or(("", ""), |ladder| (&*ladder.name, &*ladder.unit));
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        let (short, rounded) = (shortest(self.ladder), significant(self.ladder));
        let value = if short.len() > rounded.len() { rounded } else { short };
        format!("{}, {name} = {value}{unit}", self.method)
    }
}

impl Outcome {
    /// With a picture, if pictures are wanted; it is drawn only then.
    pub(crate) fn pictured(
        mut self,
        at: &Point<'_>,
        caption: &str,
        draw: impl FnOnce() -> Result<Image, ExperimentError>,
    ) -> Result<Self, ExperimentError> {
        let Some((folder, stem)) = at.frames else { return Ok(self) };
        let path = format!("{stem}.png");
        draw()?.save_png(&folder.join(&path)).map_err(ExperimentError::stopped)?;
        self.pictures.push(Picture { path, caption: caption.to_owned() });
        Ok(self)
    }

    /// With a chart, if pictures are wanted.
    pub(crate) fn charted(
        self,
        at: &Point<'_>,
        caption: &str,
        chart: &Chart,
    ) -> Result<Self, ExperimentError> {
        self.pictured(at, caption, || Ok(draw_chart(chart, Size { width: 800, height: 520 })))
    }

    /// With a film, if pictures are wanted and there are frames.
    pub(crate) fn filmed(
        mut self,
        at: &Point<'_>,
        caption: &str,
        film: &Film,
    ) -> Result<Self, ExperimentError> {
        let (Some((folder, stem)), false) = (at.frames, film.frames().is_empty()) else { return Ok(self) };
        let path = format!("{stem}.gif");
        film.save_gif(&folder.join(&path)).map_err(ExperimentError::stopped)?;
        self.pictures.push(Picture { path, caption: caption.to_owned() });
        Ok(self)
    }

    /// With a film and its last frame.
    pub(crate) fn filmed_to_the_end(
        self,
        at: &Point<'_>,
        caption: &str,
        film: &Film,
    ) -> Result<Self, ExperimentError> {
        let Some(last) = film.frames().last() else { return Ok(self) };
        self.filmed(at, caption, film)?.pictured(at, &format!("{caption}: the end"), || Ok(last.clone()))
    }
}
