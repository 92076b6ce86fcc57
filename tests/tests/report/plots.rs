//! Drawings: well-formed, labelled, without overlap, and defined for every odd scene.

use crate::fixture::{ODD, broken_scene, everything, line, row, scene};
use crate::markup::{Element, elements};
use validation::record::{Exit, SceneRecord};
use validation::report::plot::{MAX_LINES, Plot, convergence, work_precision};

fn drawings(scene: &SceneRecord) -> Vec<Plot> {
    let more = scene.measures.iter().filter_map(|measure| convergence(scene, measure));
    work_precision(scene).into_iter().chain(more).collect()
}

fn of_class<'a>(found: &'a [Element], class: &str) -> Vec<&'a Element> {
    found.iter().filter(|e| e.attribute("class") == Some(class)).collect()
}

/// Every number of a drawing is finite, and everything drawn lies on the sheet.
fn assert_sound(svg: &str) -> Vec<Element> {
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    let found = elements(svg);
    for element in &found {
        for key in ["x", "cx", "x1", "x2"] {
            if element.attribute(key).is_some() {
                assert!((0.0..=640.0).contains(&element.number(key)), "{element:?}");
            }
        }
        for key in ["y", "cy", "y1", "y2"] {
            if element.attribute(key).is_some() {
                assert!((0.0..=420.0).contains(&element.number(key)), "{element:?}");
            }
        }
    }
    found
}

fn assert_labels_apart(found: &[Element]) {
    let labels = of_class(found, "label");
    for (index, a) in labels.iter().enumerate() {
        for b in &labels[index + 1..] {
            let width = |e: &Element| 7.0 * e.text.chars().count() as f64;
            let apart_y = (a.number("y") - b.number("y")).abs() >= 14.0;
            let (left, right) = if a.number("x") < b.number("x") { (a, b) } else { (b, a) };
            let apart_x = left.number("x") + width(left) <= right.number("x");
            assert!(apart_x || apart_y, "{} and {} overlap", a.text, b.text);
        }
    }
}

#[test]
fn every_drawing_is_sound_and_labels_every_line_apart() {
    for scene in everything().scenes {
        for plot in drawings(&scene) {
            for svg in [plot.inline_svg(), plot.svg_file()] {
                let found = assert_sound(&svg);
                assert_eq!(of_class(&found, "label").len(), scene.lines.len().min(MAX_LINES));
                assert_labels_apart(&found);
            }
            assert!(plot.title.contains("exact"), "the title says which way is better: {}", plot.title);
        }
    }
}

#[test]
fn markers_are_one_a_run_and_failed_ones_are_hollow_crosses() {
    let broken = broken_scene();
    for plot in drawings(&broken)[..2].iter() {
        let found = assert_sound(&plot.inline_svg());
        assert_eq!(of_class(&found, "point").len(), 4 + 5);
        let crosses = of_class(&found, "failed");
        assert_eq!(crosses.len(), 8);
        assert!(crosses.iter().all(|cross| cross.attribute("fill") == Some("none")));
        assert!(
            found.iter().any(|e| e.name == "text" && e.text == "exact (0)"),
            "the floor of exact runs is named"
        );
        assert!(found.iter().any(|e| e.name == "text" && e.text == "no result"));
    }
    let label = elements(&drawings(&broken)[0].inline_svg()).into_iter().rfind(|e| e.name == "title");
    assert!(label.is_some_and(|e| !e.text.contains('\u{1b}')));
    assert!(drawings(&broken)[0].inline_svg().contains("&lt;b&gt;"), "{ODD} is escaped");
}

/// A drawn line of the expected order and the triangle's hypotenuse are parallel.
#[test]
fn slope_triangle_has_the_slope_of_a_line_of_its_order() {
    for order in [0.5, 1.0, 2.0, 4.0, -1.0] {
        let mut scene = scene("c", "s", "t");
        scene.lines = vec![line("exactly", order, 1e-2, 1e-3, 6)];
        for row in &mut scene.lines[0].rows {
            row.errors.insert("displacement".into(), 1e-2 * row.ladder.powf(order));
        }
        scene.measures[0].order = Some(order);
        let plot = convergence(&scene, &scene.measures[0]).unwrap();
        let found = assert_sound(&plot.inline_svg());
        let points = |e: &Element| -> Vec<(f64, f64)> {
            let pair =
                |p: &str| p.split_once(',').map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).unwrap();
            e.attribute("points").unwrap().split(' ').map(pair).collect()
        };
        let triangle = points(of_class(&found, "slope")[0]);
        let path = points(found.iter().find(|e| e.name == "polyline").unwrap());
        let slope = |a: (f64, f64), b: (f64, f64)| (b.1 - a.1) / (b.0 - a.0);
        let (drawn, wanted) = (slope(triangle[0], triangle[2]), slope(path[0], path[5]));
        assert!((drawn / wanted - 1.0).abs() < 0.02, "order {order}: {drawn} for {wanted}");
        assert!(triangle.iter().all(|(x, y)| (82.0..=450.0).contains(x) && (62.0..=366.0).contains(y)));
    }
}

#[test]
fn odd_scenes_have_defined_drawings() {
    let mut one = scene("c", "s", "t");
    one.lines = vec![line("one point", 1.0, 1e-3, 1.0, 1)];
    let mut exact = scene("c", "s", "t");
    exact.lines.iter_mut().flat_map(|l| &mut l.rows).for_each(|row| {
        row.errors.values_mut().for_each(|e| *e = 0.0);
    });
    let mut failed = scene("c", "s", "t");
    failed.lines.iter_mut().flat_map(|l| &mut l.rows).for_each(|row| {
        row.errors.clear();
        row.exit = Exit::Crashed { message: "signal 11".into() };
    });
    let mut wide = scene("c", "s", "t");
    wide.lines = vec![line("wide", 1.0, 1.0, 1.0, 2), line("same", 1.0, 1.0, 1.0, 2)];
    for (row, error) in wide.lines[0].rows.iter_mut().zip([1e-290, 1e290]) {
        row.errors.insert("displacement".into(), error);
        row.seconds = error.sqrt();
    }
    let mut twenty = wide.clone();
    for (row, error) in twenty.lines[0].rows.iter_mut().zip([1e-18, 1e2]) {
        row.errors.insert("displacement".into(), error);
    }
    let mut unmeasured = scene("c", "s", "t");
    unmeasured.lines.iter_mut().flat_map(|l| &mut l.rows).for_each(|row| row.errors.clear());
    let mut negative = scene("c", "s", "t");
    negative.lines[0].rows = vec![row(-1.0, -1.0, -1.0), row(0.0, 1e-3, 0.0)];
    let mut crowd = scene("c", "s", "t");
    crowd.lines = (0..6).map(|_| line("all on one another", 2.0, 1e-2, 1e-3, 5)).collect();
    for scene in [one, exact, failed.clone(), wide, twenty, unmeasured, negative, crowd] {
        assert_eq!(drawings(&scene).len(), 3);
        for plot in drawings(&scene) {
            assert_labels_apart(&assert_sound(&plot.inline_svg()));
        }
    }
    assert!(drawings(&failed)[0].inline_svg().contains("no run completed"));
    let mut empty = scene("c", "s", "t");
    empty.lines.clear();
    assert!(drawings(&empty).is_empty());
}

#[test]
fn more_lines_than_can_be_told_apart_keep_the_best() {
    let mut crowd = scene("c", "s", "t");
    crowd.lines =
        (0..9).map(|k| line(&format!("line {k}"), 2.0, 1e-2, 1e-3 * (9.0 - f64::from(k)), 4)).collect();
    let plot = work_precision(&crowd).unwrap();
    assert_eq!(plot.series.len(), MAX_LINES);
    assert!(plot.series.iter().any(|series| series.label == "line 8"), "the cheapest is drawn");
    assert!(plot.note.contains("best 6 of 9"), "{}", plot.note);
}
