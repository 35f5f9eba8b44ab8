//! The model as C99 that depends on `<math.h>` alone.

use super::source::{Source, literal, literals};
use std::fmt::Write;

/// Newton-Euler over the tables; joint frames as Khalil and Craig place them, z along the joint.
const BODY: &str = include_str!("templates/model.c");

/// Of the functions with memory, for the top of the file.
const DECLARATIONS: &str = " *   int @PREFIX@_predict(long count, double sample_time, const double *q, const double *qd, const double *qdd, double *tau);
 *   size_t @PREFIX@_state_size(void);
 *   int @PREFIX@_reset(struct @PREFIX@_state *state, double sample_time);
 *   void @PREFIX@_step(struct @PREFIX@_state *state, const double *q, const double *qd, const double *qdd, double *tau);
";

impl Source {
    pub(super) fn c(&self, remarks: &[String]) -> String {
        let mut text = String::new();
        let how = "Functions whose names end with _at take them as channels: CHANNELS values in this order (predict_at: of every sample). The other functions, and \
            NAN as a value, stand for a quantity that is not measured: effects then take its reference.";
        for (at, line) in self.heading(remarks, how).iter().enumerate() {
            let _ = writeln!(text, "{} {line}", if at == 0 { "/*" } else { " *" });
        }
        text.push_str(" */\n");
        let prefix = identifier(&self.robot);
        let (torque, mass) = self.c_statements();
        let filled = self
            .channels
            .in_c(
                &BODY.replace("@MEMORY_PART@", &self.memory.c(&self.robot_gravity)),
                !self.memory.is_empty(),
            )
            .replace("@TABLES@", &self.c_tables())
            .replace("@EFFECTS@", &torque)
            .replace("@MASS@", &mass)
            .replace("@DECLARATIONS@", if self.memory.is_empty() { "" } else { DECLARATIONS })
            .replace("@PREFIX@", &prefix);
        text + &filled
    }

    fn c_tables(&self) -> String {
        let mut text = format!("enum {{ N = {} }};\n\n", self.joints.len());
        let _ = writeln!(text, "static const double GRAVITY[3] = {{{}}};", literals(&self.gravity));
        let mut table = |comment: &str, kind: &str, name: &str, rows: Vec<String>| {
            let _ = writeln!(
                text,
                "/* {comment} */\nstatic const {kind} {name} = {{\n    {},\n}};",
                rows.join(",\n    ")
            );
        };
        let rows = |row: &dyn Fn(&super::source::SourceJoint) -> String| self.joints.iter().map(row).collect::<Vec<_>>();
        let matrix = |m: &[[f64; 3]; 3]| {
            format!(
                "{{{{{}}}, {{{}}}, {{{}}}}}",
                literals(&m[0]),
                literals(&m[1]),
                literals(&m[2])
            )
        };
        table(
            "1: turns about z, 0: slides along z",
            "int",
            "REVOLUTE[N]",
            rows(&|j| u8::from(j.revolute).to_string()),
        );
        table(
            "pose of every joint frame in the one before it at q = 0",
            "double",
            "ROTATION[N][3][3]",
            rows(&|j| matrix(&j.rotation)),
        );
        table(
            "(m)",
            "double",
            "TRANSLATION[N][3]",
            rows(&|j| format!("{{{}}}", literals(&j.translation))),
        );
        table("added to the positions", "double", "OFFSET[N]", rows(&|j| literal(j.offset)));
        table("(kg)", "double", "MASS[N]", rows(&|j| literal(j.body.mass)));
        table(
            "mass times centre of mass (kg m)",
            "double",
            "MOMENT[N][3]",
            rows(&|j| format!("{{{}}}", literals(j.body.first_moment.as_slice()))),
        );
        table(
            "about the joint frame (kg m^2)",
            "double",
            "INERTIA[N][3][3]",
            rows(&|j| matrix(&std::array::from_fn(|r| std::array::from_fn(|c| j.body.inertia[(r, c)])))),
        );
        table("viscous friction", "double", "VISCOUS[N]", rows(&|j| literal(j.viscous)));
        table("Coulomb friction", "double", "COULOMB[N]", rows(&|j| literal(j.coulomb)));
        table(
            "factor of the torque channel",
            "double",
            "GAIN[N]",
            rows(&|j| literal(j.gain)),
        );
        text
    }

    /// Onto the torques, and onto the mass matrix.
    fn c_statements(&self) -> (String, String) {
        let (mut torque, mut mass) = (String::new(), String::new());
        for effect in &self.effects {
            let comment = &effect.comment;
            for (text, list) in [(&mut torque, &effect.torque), (&mut mass, &effect.mass)] {
                if !list.is_empty() {
                    let _ = writeln!(text, "    /* {comment} */");
                }
                for s in list {
                    let _ = writeln!(text, "    {s};");
                }
            }
        }
        (torque, mass)
    }
}

/// A prefix for C's names from the name of a robot.
fn identifier(name: &str) -> String {
    let words: String = name
        .to_lowercase()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
        .take(40)
        .collect();
    let words = words.trim_matches('_').to_string();
    match words.chars().next() {
        Some(first) if first.is_ascii_alphabetic() => words,
        _ => format!("robot_{words}").trim_end_matches('_').to_string(),
    }
}
