//! What a run has found, as a page of Markdown: the share of scenes over each bound by model, where they are over it, and the
//! worst ten with their pictures.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use super::bounds::{BOUNDS, Miss};
use super::row::Row;

/// How many of the worst are listed.
const WORST: usize = 10;

/// The page. `folder`: that of the run, where pictures are.
pub fn page(rows: &[Row], head: &str, folder: &Path) -> String {
    let drawn: Vec<&Row> = rows.iter().filter(|row| row.problem.is_none()).collect();
    let mut page = format!("# Hunt\n\n{head}\n\n");
    let failed: Vec<(&Row, Miss)> =
        drawn.iter().filter_map(|row| Some((*row, row.worst()?))).collect();
    let far = failed.iter().filter(|(_, miss)| miss.times() > 2.0).count();
    let share = |count: usize, of: usize| 100.0 * count as f64 / of.max(1) as f64;
    let _ = writeln!(
        page,
        "{} scenes: {} could not be drawn, {} ({:.1} %) miss a bound, {far} of those by more than twice. \
         A miss with a warning, or where the reference's noise is over half of the bound, does not count.\n",
        rows.len(),
        rows.len() - drawn.len(),
        failed.len(),
        share(failed.len(), drawn.len())
    );
    by_bound(&mut page, &drawn);
    by_tag(&mut page, &drawn);
    worst(&mut page, failed, folder);
    for row in rows.iter().filter(|row| row.problem.is_some()) {
        let _ = writeln!(page, "- scene {}: {}", row.number, row.problem.as_deref().unwrap_or(""));
    }
    let seconds: f64 = rows.iter().map(|row| row.seconds).sum();
    let of_reference: f64 = rows.iter().map(|row| row.reference_seconds).sum();
    let _ = writeln!(page, "\n{:.0} s, {:.0} s of them for references.", seconds, of_reference);
    page
}

/// A row a model, a column a figure.
fn by_bound(page: &mut String, drawn: &[&Row]) {
    page.push_str(
        "| scenes over the bound of | box | dots | flip | step | bytes | error | any |\n",
    );
    page.push_str("|---|---|---|---|---|---|---|---|\n");
    for model in ["fast", "auto", "exact"] {
        let mut line = format!("| `{model}` |");
        let counts = |figure: Option<&str>| {
            let of = |miss: &Miss| {
                miss.counts() && miss.model == model && figure.is_none_or(|f| f == miss.figure)
            };
            drawn.iter().filter(|row| row.misses().iter().any(of)).count()
        };
        let asked = |figure: &str| {
            let is_asked = |row: &&&Row| match figure {
                "step" => row.models.get(model).is_some_and(|model| model.step.is_some()),
                "bytes" => row.models.get(model).is_some_and(|model| model.bytes.is_some()),
                "error" => row.error.is_some() && model == "auto",
                _ => true,
            };
            drawn.iter().filter(is_asked).count()
        };
        for figure in BOUNDS.map(|(name, _)| name).into_iter().chain(["error"]) {
            match asked(figure) {
                0 => line.push_str(" |"),
                of => {
                    let _ = write!(line, " {} of {of} |", counts(Some(figure)));
                }
            }
        }
        let _ = writeln!(page, "{line} {} of {} |", counts(None), drawn.len());
    }
    let all = drawn.iter().flat_map(|row| row.misses());
    let (mut warned, mut unsure) = (0, 0);
    for miss in all {
        warned += usize::from(miss.is_warned);
        unsure += usize::from(miss.is_unsure && !miss.is_warned);
    }
    let _ = writeln!(
        page,
        "\nFigures over a bound that do not count: {warned} with a warning, {unsure} unsure.\n"
    );
}

/// How often scenes with something miss a bound of `fast` and of `exact`.
fn by_tag(page: &mut String, drawn: &[&Row]) {
    let mut tags: BTreeMap<&str, [usize; 3]> = BTreeMap::new();
    for row in drawn {
        let misses = row.misses();
        let of = |model: &str| misses.iter().any(|miss| miss.counts() && miss.model == model);
        for tag in &row.tags {
            let counts = tags.entry(tag).or_default();
            counts[0] += 1;
            counts[1] += usize::from(of("fast"));
            counts[2] += usize::from(of("exact"));
        }
    }
    page.push_str("| scenes with | all | `fast` misses | `exact` misses |\n|---|---|---|---|\n");
    for (tag, [all, fast, exact]) in tags {
        let _ = writeln!(page, "| {tag} | {all} | {fast} | {exact} |");
    }
    page.push('\n');
}

fn worst(page: &mut String, mut failed: Vec<(&Row, Miss)>, folder: &Path) {
    failed.sort_by(|(_, a), (_, b)| b.times().total_cmp(&a.times()));
    page.push_str(
        "| the worst | model | figure | is | bound | it has |\n|---|---|---|---|---|---|\n",
    );
    for (row, miss) in failed.iter().take(WORST) {
        let Miss { model, figure, value, bound, .. } = miss;
        let digits = if *figure == "flip" || *figure == "error" { 3 } else { 1 };
        let _ = writeln!(
            page,
            "| {} | `{model}` | {figure} | {value:.digits$} | {bound} | {} |",
            row.number,
            row.tags.join(", ")
        );
    }
    page.push_str("\nFrom left to right: `fast`, `exact`, the reference, and four times what each differs by.\n\n");
    for (row, _) in failed.iter().take(WORST) {
        let place = super::keep::folder(Path::new(""), row.number).join("side.png");
        if folder.join(&place).exists() {
            let _ = writeln!(page, "![scene {}]({})\n", row.number, place.display());
        }
    }
}
