//! The model as Python that depends on its standard library alone.

use super::source::{Source, SourceJoint, literal, literals};
use std::fmt::Write;

const BODY: &str = include_str!("templates/model.py");

impl Source {
    pub(super) fn python(&self, remarks: &[String]) -> String {
        let how = "The argument channels is a dictionary of them by name (predict: of a series each). Without it, and without a name in it, effects take the \
            reference of the quantity.";
        let heading = self.heading(remarks, how).join("\n");
        let (torque, mass) = self.python_statements();
        let filled = self
            .channels
            .in_python(&BODY.replace("@MEMORY_PART@", &self.memory.python(&self.robot_gravity)))
            .replace("@TABLES@", &self.python_tables())
            .replace("@EFFECTS@", &torque)
            .replace("@MASS@", &mass);
        format!("\"\"\"{heading}\n\"\"\"\n{filled}")
    }

    fn python_tables(&self) -> String {
        let names: Vec<String> = self
            .joints
            .iter()
            .map(|j| serde_json::to_string(&j.name).expect("text"))
            .collect();
        let mut text = format!("JOINTS = [{}]\nN = {}\n", names.join(", "), self.joints.len());
        let _ = writeln!(text, "GRAVITY = ({})", literals(&self.gravity));
        let mut table = |name: &str, row: &dyn Fn(&SourceJoint) -> String| {
            let rows: Vec<String> = self.joints.iter().map(row).collect();
            let _ = writeln!(text, "{name} = [\n    {},\n]", rows.join(",\n    "));
        };
        let matrix = |m: &[[f64; 3]; 3]| format!("(({}), ({}), ({}))", literals(&m[0]), literals(&m[1]), literals(&m[2]));
        table("REVOLUTE", &|j| if j.revolute { "True".into() } else { "False".into() });
        table("ROTATION", &|j| matrix(&j.rotation));
        table("TRANSLATION", &|j| format!("({})", literals(&j.translation)));
        table("OFFSET", &|j| literal(j.offset));
        table("MASS", &|j| literal(j.body.mass));
        table("MOMENT", &|j| format!("({})", literals(j.body.first_moment.as_slice())));
        table("INERTIA", &|j| {
            matrix(&std::array::from_fn(|r| std::array::from_fn(|c| j.body.inertia[(r, c)])))
        });
        table("VISCOUS", &|j| literal(j.viscous));
        table("COULOMB", &|j| literal(j.coulomb));
        table("GAIN", &|j| literal(j.gain));
        text
    }

    fn python_statements(&self) -> (String, String) {
        let (mut torque, mut mass) = (String::new(), String::new());
        for effect in &self.effects {
            for (text, list) in [(&mut torque, &effect.torque), (&mut mass, &effect.mass)] {
                if !list.is_empty() {
                    let _ = writeln!(text, "    # {}", effect.comment);
                }
                for s in list {
                    let _ = writeln!(text, "    {s}");
                }
            }
        }
        (torque, mass)
    }
}
