//! What can be handed over? A page with the picture, the verdict, the places and where everything came from; no network.

use std::fmt::Write;

use planwalk_types::Estimate;

use crate::result::{ContradictedKindEntry, ResultFile, length_m};
use crate::words;

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:1500px;margin:2em auto;padding:0 1em;color:#1b1f24}\
 table{border-collapse:collapse;margin:.5em 0 1.5em}td,th{border:1px solid #d0d7de;padding:.3em .7em;text-align:left}\
 td.number{text-align:right;font-variant-numeric:tabular-nums}code{font-size:12px;word-break:break-all}\
 svg{max-width:100%;height:auto}h1{font-size:1.5em}h2{font-size:1.15em;margin-top:1.6em}.verdict{font-size:1.15em}";

/// The page: `title`, the pictures as SVG with a caption each, and the result in words and tables.
pub fn html(title: &str, pictures: &[(&str, &str)], result: &ResultFile, track: &[Estimate]) -> String {
    let mut page = String::new();
    let title = escape(title);
    // Writing to a String cannot fail.
    let _ = write!(
        page,
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title><style>{STYLE}</style></head><body>\n<h1>{title}</h1>\n"
    );
    verdict(&mut page, result, track);
    for (caption, svg) in pictures {
        let _ = write!(page, "<h2>{}</h2>\n{svg}\n", escape(caption));
    }
    hypotheses(&mut page, result);
    contradicted(&mut page, result);
    quality(&mut page, result);
    origin(&mut page, result);
    page.push_str("</body></html>\n");
    page
}

fn verdict(page: &mut String, result: &ResultFile, track: &[Estimate]) {
    let (Some(status), Some(end)) = (result.status, track.last()) else { return };
    let probability = result.hypotheses.first().map_or(0.0, |h| h.probability);
    let _ = writeln!(page, "<p class=\"verdict\"><strong>{status}</strong>: {}</p>", escape(&words::verdict(status, probability)));
    let seconds = track.first().map_or(0.0, |first| end.stamp.secs_since(first.stamp));
    let _ = write!(page, "<p>{:.1} m walked in {seconds:.1} s; the walk ends at {}.", length_m(track), escape(&words::end_pose(end)));
    if let Some(scale) = &result.scale {
        let _ = write!(page, " {}.", escape(&words::scale(scale)));
    }
    page.push_str("</p>\n");
    if let Some(truth) = &result.truth {
        let inside = if truth.truth_in_region95 { "inside" } else { "outside" };
        let (end, median) = (truth.truth_end_error_m, truth.truth_median_error_m);
        let _ =
            writeln!(page, "<p>Against the truth: {end:.2} m off at the end ({inside} the 95 % region), {median:.2} m in the median.</p>");
    }
}

fn hypotheses(page: &mut String, result: &ResultFile) {
    page.push_str(
        "<h2>Places that explain the walk</h2>\n<table><tr><th>probability</th><th>end x / m</th><th>end y / m</th><th>heading / °</th>",
    );
    page.push_str("<th>95 % within / m</th><th>metres per unit</th></tr>\n");
    for h in &result.hypotheses {
        let cells = [
            words::percent(h.probability),
            format!("{:.2}", h.pose.x_m),
            format!("{:.2}", h.pose.y_m),
            format!("{:.0}", h.pose.yaw_rad.to_degrees()),
            format!("{:.2}", h.radius95_m),
            format!("{:.3} ± {:.0} %", h.scale.metres_per_unit, 100.0 * h.scale.relative_sigma),
        ];
        let cells: String = cells.iter().map(|c| format!("<td class=\"number\">{}</td>", escape(c))).collect();
        let _ = writeln!(page, "<tr>{cells}</tr>");
    }
    page.push_str("</table>\n");
    if !result.apart.is_empty() {
        let items: String = result.apart.iter().map(|a| format!("<li>{}</li>", escape(&words::apart(a)))).collect();
        let _ = writeln!(page, "<h2>What would tell them apart</h2>\n<ul>{items}</ul>");
    }
}

fn contradicted(page: &mut String, result: &ResultFile) {
    let Some(said) = words::contradicted(&result.contradicted) else { return };
    let _ = write!(
        page,
        "<h2>Walls that the walk contradicts</h2>\n<p>{}.</p>\n<table><tr><th>how</th><th>x / m</th><th>y / m</th><th>extent / m</th>\
         <th>times crossed</th><th>looks through</th><th>looks that end there</th></tr>\n",
        escape(&said)
    );
    for wall in &result.contradicted {
        let how = match wall.kind {
            ContradictedKindEntry::Crossed => format!("crossed ({})", words::percent(wall.confidence)),
            ContradictedKindEntry::SeenThrough => "seen through".to_owned(),
        };
        let numbers = [
            format!("{:.2}", wall.x_m),
            format!("{:.2}", wall.y_m),
            format!("{:.1}", wall.length_m),
            wall.times_crossed.to_string(),
            wall.rays_through.to_string(),
            wall.rays_ending.to_string(),
        ];
        let cells: String = numbers.iter().map(|n| format!("<td class=\"number\">{n}</td>")).collect();
        let _ = writeln!(page, "<tr><td>{}</td>{cells}</tr>", escape(&how));
    }
    page.push_str("</table>\n");
}

fn quality(page: &mut String, result: &ResultFile) {
    let Some(q) = &result.quality else { return };
    let _ = writeln!(
        page,
        "<h2>How well it holds up</h2>\n<table><tr><th>seen points on drawn walls</th><td class=\"number\">{:.0} % of {}</td></tr>\n\
         <tr><th>seen through drawn walls</th><td class=\"number\">{:.0} %</td></tr>\n\
         <tr><th>walls crossed by the track</th><td class=\"number\">{}</td></tr>\n\
         <tr><th>particles, at most and at the end</th><td class=\"number\">{} → {}</td></tr></table>",
        100.0 * q.seen_explained,
        q.seen,
        100.0 * q.seen_through_walls,
        q.wall_crossings,
        q.particles_max,
        q.particles_end
    );
    if let Some(sigma_m) = q.plan_sigma_m {
        let _ =
            writeln!(page, "<p>Drawn walls stand off by {:.0} cm (one standard deviation, measured along the walk).</p>", 100.0 * sigma_m);
    }
    if !result.gaps.is_empty() {
        page.push_str("<h2>Bad stretches of the video</h2>\n<table><tr><th>from / s</th><th>to / s</th><th>cause</th></tr>\n");
        for gap in &result.gaps {
            let _ = writeln!(
                page,
                "<tr><td class=\"number\">{:.2}</td><td class=\"number\">{:.2}</td><td>{}</td></tr>",
                gap.from_s,
                gap.to_s,
                escape(&gap.cause)
            );
        }
        page.push_str("</table>\n");
    }
}

fn origin(page: &mut String, result: &ResultFile) {
    page.push_str("<h2>Where this comes from</h2>\n<table><tr><th>input</th><th>path</th><th>SHA-256</th></tr>\n");
    for input in &result.inputs {
        let (role, path, hash) = (escape(&input.role), escape(&input.path), escape(&input.sha256));
        let _ = writeln!(page, "<tr><td>{role}</td><td>{path}</td><td><code>{hash}</code></td></tr>");
    }
    let _ = writeln!(
        page,
        "</table>\n<p>planwalk {} {} --seed {}{}</p>",
        escape(&result.version),
        escape(&result.command),
        result.seed.0,
        escape(&result.options.iter().map(|o| format!(" --{} {}", o.name, o.value)).collect::<String>())
    );
    if !result.notes.is_empty() {
        let notes: String = result.notes.iter().map(|n| format!("<li>{}</li>", escape(n))).collect();
        let _ = writeln!(page, "<h2>Notes</h2>\n<ul>{notes}</ul>");
    }
}

/// Text that cannot become markup.
fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            c => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::InputEntry;
    use planwalk_types::Seed;

    #[test]
    fn file_names_cannot_become_markup() {
        let mut result = ResultFile::new("locate", Seed(0));
        let path = "<script>alert('&')</script>.mp4".to_owned();
        result.inputs.push(InputEntry { role: "video".to_owned(), path: path.clone(), sha256: "00".to_owned() });
        result.notes.push(path.clone());
        let page = html(&path, &[("<b>", "<svg></svg>")], &result, &[]);
        assert!(!page.contains("<script>") && !page.contains("<b>"), "{page}");
        assert!(page.contains("&lt;script&gt;") && page.contains("<svg></svg>"));
    }

    #[test]
    fn the_page_asks_the_network_for_nothing() {
        let page = html("a", &[], &ResultFile::new("locate", Seed(0)), &[]);
        assert!(!page.contains("http") && !page.contains("src="), "{page}");
    }
}
