//! The page in a real browser, named by the environment variable `CHROMIUM`.

use crate::fixture::everything;
use crate::fresh_folder;
use std::io::Write;
use std::path::Path;
use std::process::Command;
use validation::picture::{Camera, Film, Scene3, Size, render};
use validation::report::{PlotFiles, write_report};

/// Sorts every column of the first table by press and by keyboard focus, follows a link, and writes what it saw into the
/// page's title.
const PROBE: &str = r##"<script>
const problems = [];
addEventListener("error", e => problems.push("error: " + e.message));
addEventListener("load", () => {
  const table = document.querySelector("#scenes table");
  const heads = [...table.tHead.rows[0].cells];
  const column = i => [...table.tBodies[0].rows].map(row => {
    const cell = row.cells[i];
    return cell.dataset.sort === undefined ? cell.textContent : cell.dataset.sort === "" ? null : Number(cell.dataset.sort);
  });
  heads.forEach((head, i) => {
    for (const wanted of ["ascending", "descending"]) {
      const button = head.querySelector("button");
      button.focus();
      if (document.activeElement !== button) problems.push("no focus " + i);
      button.click();
      if (head.getAttribute("aria-sort") !== wanted) problems.push("aria-sort " + i);
      if (heads.filter(h => h.getAttribute("aria-sort") !== "none").length !== 1) problems.push("two sorted");
      const values = column(i), present = values.filter(v => v !== null);
      if (values.slice(present.length).some(v => v !== null)) problems.push("empty not last " + i);
      for (let k = 1; k < present.length; k++) {
        const [a, b] = wanted === "ascending" ? [present[k - 1], present[k]] : [present[k], present[k - 1]];
        if (typeof a === "number" ? a > b : a.localeCompare(b, "en", { numeric: true }) > 0) problems.push("order " + i);
      }
    }
  });
  const link = table.querySelector("a[href^='#scene-']");
  const section = document.getElementById(decodeURIComponent(link.hash.slice(1)));
  section.open = false;
  location.hash = link.hash;
  setTimeout(() => {
    if (!section.open) problems.push("the link did not open its section");
    if (document.documentElement.scrollWidth > innerWidth + 1) problems.push("the page scrolls sideways");
    for (const image of document.images) {
      image.loading = "eager";
    }
    document.title = problems.length ? "PROBLEMS " + problems.join("; ") : "ALL WELL " + table.tBodies[0].rows.length;
  }, 300);
});
</script>"##;

/// Says it past the test harness, which shows what a test prints only if it fails: the gate counts these lines.
fn skipped(reason: &str) {
    std::io::stderr().write_all(format!("\nSKIPPED ({reason})\n").as_bytes()).expect("standard error");
}

#[test]
fn page_works_in_a_browser() {
    let Some(browser) = std::env::var_os("CHROMIUM") else {
        skipped("set CHROMIUM to the name of a Chromium or Chrome to look at the page in it");
        return;
    };
    let folder = fresh_folder("browser");
    picture(&folder.join("frames/cube.png"));
    let made = everything();
    write_report(&made, &folder, PlotFiles::Write).unwrap();
    let html = std::fs::read_to_string(folder.join("index.html")).unwrap();
    std::fs::write(folder.join("probe.html"), html.replacen("<title>", &format!("{PROBE}<title>"), 1))
        .unwrap();
    for (name, width) in [("wide", 1280), ("phone", 400)] {
        let profile = folder.join(format!("profile-{name}"));
        let size = format!("--window-size={width},900");
        let (dom, console) = run(
            &browser,
            &profile,
            &[&size, "--virtual-time-budget=4000", "--dump-dom"],
            &folder.join("probe.html"),
        );
        let rows: usize = made.scenes.iter().map(|scene| scene.lines.len().max(1)).sum();
        assert!(dom.contains(&format!("<title>ALL WELL {rows}</title>")), "{:?}", dom.get(..3000));
        let complaints: Vec<&str> = console.lines().filter(|line| line.contains("CONSOLE")).collect();
        assert!(complaints.is_empty(), "{complaints:?}");
        let _ = std::fs::remove_dir_all(&profile);
    }
}

fn run(browser: &std::ffi::OsStr, profile: &Path, options: &[&str], page: &Path) -> (String, String) {
    let output = Command::new(browser)
        .args("--headless --no-sandbox --disable-gpu --disable-quic --no-first-run".split(' '))
        .args("--disable-background-networking --disable-component-update --disable-sync".split(' '))
        .args(["--enable-logging=stderr", "--v=0"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .args(options)
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("the browser that CHROMIUM names starts");
    (String::from_utf8_lossy(&output.stdout).into(), String::from_utf8_lossy(&output.stderr).into())
}

fn picture(path: &Path) {
    let scene = Scene3 {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]],
        ..Scene3::default()
    };
    let image = render(&scene, &Camera::default(), Size { width: 480, height: 360 });
    image.save_png(path).expect("a picture");
    let mut film = Film::new(0.1);
    film.push(image).expect("one frame");
    film.save_gif(&path.with_extension("gif")).expect("a film");
}
