//! Base parameters, bodies and effects as one table.

use super::FinalModel;
use crate::model::shortest;

impl FinalModel {
    /// Columns `kind, name, joint, value, std_dev, unit, expression`; lines end with a line feed.
    pub(super) fn csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let mut put = |row: [&str; 7]| writer.write_record(row).expect("writing to memory does not fail");
        put(["kind", "name", "joint", "value", "std_dev", "unit", "expression"]);
        let text = |v: Option<f64>| v.map_or_else(String::new, shortest);
        for row in &self.base_parameters {
            let (value, std_dev) = (text(row.value), text(row.std_dev));
            put(["base_parameter", &row.name, "", &value, &std_dev, &row.unit, &row.expression]);
        }
        for (j, joint) in self.robot.joints().iter().enumerate() {
            for (name, value, unit) in self.body_values(j) {
                put(["body", name, &joint.name, &shortest(value), "", &unit, ""]);
            }
        }
        for (term, deviations) in self.terms.iter().zip(&self.deviations) {
            let values = term.effect.reported(term.form, &term.coefficients, &term.shape);
            let infos = term.effect.parameters(term.form, &self.robot, &term.joints);
            let joints = self.joint_names(term).join(" ");
            for (at, (info, value)) in infos.iter().zip(values).enumerate() {
                let std_dev = text(deviations.get(at).copied().flatten());
                let name = format!("{}.{}", term.effect.code(), info.name);
                put(["effect", &name, &joints, &shortest(value), &std_dev, &info.unit, ""]);
            }
        }
        String::from_utf8(writer.into_inner().expect("writing to memory does not fail")).expect("made of text")
    }

    /// Mass, centre of mass and inertia about it in the link frame of the description, and friction.
    fn body_values(&self, j: usize) -> Vec<(&'static str, f64, String)> {
        let joint = &self.robot.joints()[j];
        let Some(prior) = &joint.prior else { return Vec::new() };
        let turn = joint.description_frame;
        let c = turn * prior.inertia.center_of_mass;
        let i = turn * prior.inertia.inertia * turn.transpose();
        let rate = if joint.is_revolute() { "N m s/rad" } else { "N s/m" };
        let mut list = vec![("mass", prior.inertia.mass, "kg".to_string())];
        let center = ["center_x", "center_y", "center_z"].into_iter().zip(c.iter());
        list.extend(center.map(|(name, v)| (name, *v, "m".to_string())));
        let entries = [
            ("xx", 0, 0),
            ("xy", 0, 1),
            ("xz", 0, 2),
            ("yy", 1, 1),
            ("yz", 1, 2),
            ("zz", 2, 2),
        ];
        list.extend(entries.map(|(name, r, c)| (name, i[(r, c)], "kg m^2".to_string())));
        list.push(("viscous", prior.viscous, rate.into()));
        list.push(("coulomb", prior.coulomb, joint.effort_unit().into()));
        list
    }
}
