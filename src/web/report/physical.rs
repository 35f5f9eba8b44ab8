//! The part of the report on physical parameters, and their margins.

use super::html::{Html, capital, text, words};
use crate::documents::{IdentifyDocument, MarginValue, PhysicalValue};

pub(super) fn physical(page: &mut Html, result: &IdentifyDocument) {
    let Some(bodies) = result.physical_parameters.as_ref().filter(|b| !b.is_empty()) else {
        return;
    };
    page.heading(2, "Physical parameters");
    let link = |l: &PhysicalValue| format!("{} {}", text(&l.link), text(&l.name));
    // Two tables: all of it in one is wider than a page.
    let body = |l: &PhysicalValue| {
        let c = &l.center_of_mass;
        let numbers = [l.mass, c[0], c[1], c[2], l.viscous, l.coulomb];
        std::iter::once(link(l)).chain(numbers.map(|v| text(&v))).collect::<Vec<_>>()
    };
    page.table(
        "In the frames of the robot's description",
        &["Link", "#Mass (kg)", "#x (m)", "#y (m)", "#z (m)", "#Viscous", "#Coulomb"],
        bodies.iter().map(body),
    );
    let inertia = |l: &PhysicalValue| {
        let i = &l.inertia;
        let numbers = [i.xx, i.yy, i.zz, i.xy, i.xz, i.yz].map(|v| text(&v));
        std::iter::once(link(l)).chain(numbers).collect::<Vec<_>>()
    };
    page.table(
        "Inertia about the centre of mass (kg·m²)",
        &["Link", "#Ixx", "#Iyy", "#Izz", "#Ixy", "#Ixz", "#Iyz"],
        bodies.iter().map(inertia),
    );
    let all = result.feasibility.as_ref().map_or(&[][..], |f| &f.margins);
    margins(page, all);
    let row = |m: &MarginValue| {
        vec![
            text(&m.link),
            capital(&words(&m.constraint)),
            text(&m.margin),
            text(&m.cost_percent),
        ]
    };
    let active: Vec<Vec<String>> = all.iter().filter(|m| m.active).map(row).collect();
    if !active.is_empty() {
        page.table(
            "Active constraints: these, and not only the log, determine the bodies. Cost: increase of the residual by each",
            &["Link", "Constraint", "#Margin", "#Cost (%)"],
            active.into_iter(),
        );
    }
}

/// A row per link and a column per constraint.
fn margins(page: &mut Html, margins: &[MarginValue]) {
    let (mut links, mut constraints): (Vec<usize>, Vec<String>) = (Vec::new(), Vec::new());
    for m in margins {
        if !links.contains(&m.link) {
            links.push(m.link);
        }
        if !constraints.contains(&words(&m.constraint)) {
            constraints.push(words(&m.constraint));
        }
    }
    let of = |link: usize, constraint: &String| {
        let found = margins.iter().find(|m| m.link == link && words(&m.constraint) == *constraint);
        found.map_or("–".into(), |m| text(&m.margin))
    };
    let heads: Vec<String> = constraints.iter().map(|c| format!("#{}", capital(c))).collect();
    let heads: Vec<&str> = std::iter::once("Link").chain(heads.iter().map(String::as_str)).collect();
    let row = |link: &usize| {
        std::iter::once(text(link))
            .chain(constraints.iter().map(|c| of(*link, c)))
            .collect::<Vec<_>>()
    };
    page.table(
        "Margins of physical consistency: above zero where it is satisfied",
        &heads,
        links.iter().map(row),
    );
}
