//! Million particle-steps a second.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]
mod scene;
use scene::*;

fn named(name: &str, size: Size, plane: Size) -> Box<dyn Stepped> {
    match name {
        "jelly" => scene::<f32, 3, _>(jelly(), size),
        "jelly64" => scene::<f64, 3, _>(jelly(), size),
        "rubber" => scene::<f32, 3, _>(rubber(), size),
        "water" => scene::<f32, 3, _>(water(), size),
        "metal" => scene::<f32, 3, _>(metal(), size),
        "sand" => scene::<f32, 3, _>(sand(), size),
        "plane" => scene::<f32, 2, _>(jelly(), plane),
        _ => panic!("{name}"),
    }
}

fn main() {
    let a: Vec<String> = std::env::args().collect();
    if a[1] == "--walk" {
        let mut s = named(&a[2], Size { nodes: 24, cells: 12 }, Size { nodes: 128, cells: 56 });
        s.run(a[3].parse().unwrap(), 1);
        println!("{} particles", s.particles());
        return;
    }
    for name in ["jelly", "jelly64", "rubber", "water", "metal", "sand", "plane"] {
        if a.len() > 1 && a[1] != "--all" && !a[1..].iter().any(|x| x == name) { continue; }
        let mut s = named(name, SMALL, PLANE);
        s.run(3, 1);
        let mut t: Vec<f64> = (0..9).map(|_| s.run(10, 1)).collect();
        t.sort_by(f64::total_cmp);
        let n = s.particles() as f64;
        println!("{name:8} median {:6.2} ns best {:6.2} ns  {:5.2} M/s best {:5.2}", t[4] / n * 1e9, t[0] / n * 1e9, n / t[4] / 1e6, n / t[0] / 1e6);
    }
}
