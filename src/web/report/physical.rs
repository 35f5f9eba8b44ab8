//! The part of the report on physical parameters, and their margins.

use super::html::{Html, capital, items, text, words};
use serde_json::Value;

pub(super) fn physical(page: &mut Html, result: &Value) {
    if items(&result["physical_parameters"]).next().is_none() {
        return;
    }
    page.heading(2, "Physical parameters");
    let link = |l: &Value| format!("{} {}", text(&l["link"]), text(&l["name"]));
    // Two tables: all of it in one is wider than a page.
    let body = |l: &Value| {
        let c = &l["center_of_mass"];
        let numbers = [&l["mass"], &c[0], &c[1], &c[2], &l["viscous"], &l["coulomb"]];
        std::iter::once(link(l)).chain(numbers.map(text)).collect::<Vec<_>>()
    };
    page.table(
        "In the frames of the robot's description",
        &["Link", "#Mass (kg)", "#x (m)", "#y (m)", "#z (m)", "#Viscous", "#Coulomb"],
        items(&result["physical_parameters"]).map(body),
    );
    let inertia = |l: &Value| {
        let numbers = ["xx", "yy", "zz", "xy", "xz", "yz"].map(|k| text(&l["inertia"][k]));
        std::iter::once(link(l)).chain(numbers).collect::<Vec<_>>()
    };
    page.table(
        "Inertia about the centre of mass (kg m²)",
        &["Link", "#Ixx", "#Iyy", "#Izz", "#Ixy", "#Ixz", "#Iyz"],
        items(&result["physical_parameters"]).map(inertia),
    );
    let all = &result["feasibility"]["margins"];
    margins(page, all);
    let row = |m: &Value| {
        vec![
            text(&m["link"]),
            capital(&words(&m["constraint"])),
            text(&m["margin"]),
            text(&m["cost_percent"]),
        ]
    };
    let active: Vec<Vec<String>> = items(all).filter(|m| m["active"] == true).map(row).collect();
    if !active.is_empty() {
        page.table(
            "Active constraints: these, and not the log alone, decide the bodies. By how much the fit is worse than the best without each",
            &["Link", "Constraint", "#Margin", "#Cost (%)"],
            active.into_iter(),
        );
    }
}

/// A row per link and a column per constraint.
fn margins(page: &mut Html, margins: &Value) {
    let (mut links, mut constraints): (Vec<&Value>, Vec<String>) = (Vec::new(), Vec::new());
    for m in items(margins) {
        if !links.contains(&&m["link"]) {
            links.push(&m["link"]);
        }
        if !constraints.contains(&words(&m["constraint"])) {
            constraints.push(words(&m["constraint"]));
        }
    }
    let of = |link: &Value, constraint: &String| {
        let found = items(margins).find(|m| m["link"] == *link && words(&m["constraint"]) == *constraint);
        found.map_or("–".into(), |m| text(&m["margin"]))
    };
    let heads: Vec<String> = constraints.iter().map(|c| format!("#{}", capital(c))).collect();
    let heads: Vec<&str> = std::iter::once("Link").chain(heads.iter().map(String::as_str)).collect();
    let row = |link: &&Value| {
        std::iter::once(text(link))
            .chain(constraints.iter().map(|c| of(link, c)))
            .collect::<Vec<_>>()
    };
    page.table(
        "Margins to what is physically possible: above zero where it is",
        &heads,
        links.iter().map(row),
    );
}
