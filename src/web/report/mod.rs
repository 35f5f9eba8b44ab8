//! The report of an identification: one HTML file that stands alone, prints, and holds what is needed to do it again.

mod formula;
mod html;
mod parts;
mod physical;
mod residual;
mod terms;

use crate::documents::IdentifyDocument;
use html::{Html, escaped};
use serde_json::Value;

const STYLE: &str = include_str!("style.css");

/// What a report may load: nothing. It stands in the file as well, for reports that are kept and opened from a disk.
pub const REPORT_POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'";

/// What the report says beside the result.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Circumstances {
    /// Id of the identification.
    pub id: Option<String>,
    /// When it ended, in words.
    pub ended: Option<String>,
    /// The design that was executed, as `POST /excitation` answered it.
    pub design: Option<Value>,
}

/// The report of `result`, an answer of `POST /identify` (schema `Identification`).
///
/// Pictures are there where the result has their series (`prediction_points` above zero) and can be drawn.
pub fn report(result: &IdentifyDocument, circumstances: &Circumstances) -> String {
    let (mut top, mut page) = (Html::default(), Html::default());
    parts::heading(&mut top, result, circumstances);
    parts::summary(&mut top, result);
    residual::diagnosis(&mut page, result);
    parts::logs(&mut page, result);
    parts::errors(&mut page, result);
    parts::parameters(&mut page, result);
    physical::physical(&mut page, result);
    parts::torques(&mut page, result);
    parts::reproduction(&mut page, result, circumstances);
    terms::terms(&mut page);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{REPORT_POLICY}\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{}{}{}</main>\n</body>\n</html>\n",
        escaped(&format!("Identification of {}", result.robot)),
        top.0,
        page.contents(),
        page.0
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn result() -> IdentifyDocument {
        let document = json!({
            "robot": "a <b>arm</b>", "joints": ["J1", "J2"], "estimator": "wls",
            "quality": {"verdict": "good", "reason": "fine & well", "condition_number": 12.5, "rank": 2, "columns": 2},
            "base_parameters": [
                {"name": "ZZR1", "expression": "ZZ1 + ZZ2", "value": 1.5, "std_dev": 0.01, "relative_std_dev_percent": 0.7, "unit": "kg m^2"},
                {"name": "MX2", "expression": "MX2", "value": null, "std_dev": null, "relative_std_dev_percent": null, "unit": "kg m"}],
            "undetermined": [], "physical_parameters": null, "feasibility": null,
            "rms": {"identification": [{"name": "a.csv", "base": {"rms": [0.1, 0.2], "percent": [1, 2], "sum": 0.3}, "physical": null}], "validation": []},
            "noise": [], "log_report": [], "residual": null, "predictions": [
                {"log": "a.csv", "joint": "J1", "time": [0.0, 1.0], "measured": [1.0, 2.0], "base": [1.1, 1.9], "physical": null, "declared": null}],
            "notes": [],
            "provenance": {"version": "0.1.0", "request": {"robot": "x</pre><script>"}, "robot": {"name": "x", "joints": []},
                "logs": [{"file": "a.csv", "role": "identification", "bytes": 3, "sha256": "ba78"}]}
        });
        serde_json::from_value(document).unwrap()
    }

    #[test]
    fn a_report_stands_alone_and_escapes_what_it_quotes() {
        let design = json!({"request": {"search": {"seed": 7}}, "coefficients": {"a": [[1.0]]}});
        let circumstances = Circumstances {
            id: Some("some-id".into()),
            ended: None,
            design: Some(design),
        };
        let page = report(&result(), &circumstances);
        assert!(!page.contains("<b>arm") && !page.contains("<script") && page.contains("a &lt;b&gt;arm"));
        for outside in ["src=", "href=\"http", "@import", "url("] {
            assert!(!page.contains(outside), "{outside} reaches outside the file");
        }
        for needed in [
            "http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'",
            "ba78",
            "0.1.0",
            "some-id",
            "&quot;seed&quot;: 7",
            "<mi mathvariant=\"normal\">ZZR</mi><mn>1</mn>",
            "<mi mathvariant=\"normal\">ZZ</mi><mn>2</mn>",
            "not determined",
            "Fine &amp; well.",
            "<dt>Noise floor</dt>",
            "<svg",
        ] {
            assert!(page.contains(needed), "{needed}");
        }
    }

    /// The parameters of effects are no base parameters, and pure numbers have no unit.
    #[test]
    fn parameters_are_counted_by_kind() {
        let mut result = result();
        (result.quality.rank, result.quality.columns) = (3, 4);
        let effect = json!([{"effect": "torque_gain", "joints": ["J1"], "in_model": true, "finding": true,
            "parameters": [{"name": "gain", "value": 1.5, "unit": "1", "std_dev": 0.25}]}]);
        result.effects = serde_json::from_value(effect).unwrap();
        let page = report(&result, &Circumstances::default());
        assert!(
            page.contains("Base parameters determined</td><td class=\"n\">1 of 2"),
            "{page}"
        );
        assert!(
            page.contains("effects and offsets determined</td><td class=\"n\">2 of 2"),
            "{page}"
        );
        assert!(page.contains("0.2500</td><td></td><td>yes</td>"), "{page}");
    }

    #[test]
    fn a_result_with_little_in_it_has_a_report() {
        let result = serde_json::from_value(json!({"robot": "r"})).unwrap();
        assert!(report(&result, &Circumstances::default()).contains("Identification of r"));
    }
}
