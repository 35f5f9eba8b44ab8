//! Further measured quantities of own effects, as arguments of functions in source code.

use super::FinalModel;
use super::source::one_line;
use crate::effects::ChannelVariable;
use std::fmt::Write;

/// A further measured quantity, whose value is an argument.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SourceChannel {
    pub name: String,
    pub unit: String,
}

/// Those of a model, in the order in which C takes them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SourceChannels(pub Vec<SourceChannel>);

/// The helper of C.
const C_HELPER: &str = "
/* A further quantity of a sample; what the effect takes where it is not measured, for no channels and for NAN. */
static double channel(const double *channels, int at, double reference)
{
    return channels && channels[at] == channels[at] ? channels[at] : reference;
}
";

/// The functions of the model without further quantities, in terms of those with them.
const C_OVERLOADS: &str = "
void @PREFIX@_inverse_dynamics(const double *q, const double *qd, const double *qdd, double *tau)
{
    @PREFIX@_inverse_dynamics_at(q, qd, qdd, NULL, tau);
}

void @PREFIX@_gravity(const double *q, double *tau) { @PREFIX@_gravity_at(q, NULL, tau); }

void @PREFIX@_mass_matrix(const double *q, double *m) { @PREFIX@_mass_matrix_at(q, NULL, m); }
";

/// The same of those with memory.
const C_MEMORY_OVERLOADS: &str = "
int @PREFIX@_predict(long count, double sample_time, const double *q, const double *qd, const double *qdd, double *tau)
{
    return @PREFIX@_predict_at(count, sample_time, q, qd, qdd, NULL, tau);
}

void @PREFIX@_step(struct @PREFIX@_state *state, const double *q, const double *qd, const double *qdd, double *tau)
{
    @PREFIX@_step_at(state, q, qd, qdd, NULL, tau);
}
";

const C_DECLARATIONS: &str = " *   void @PREFIX@_inverse_dynamics_at(const double *q, const double *qd, const double *qdd, const double *channels, double *tau);
 *   void @PREFIX@_gravity_at(const double *q, const double *channels, double *tau);
 *   void @PREFIX@_mass_matrix_at(const double *q, const double *channels, double *m);
";

const C_MEMORY_DECLARATIONS: &str = " *   int @PREFIX@_predict_at(long count, double sample_time, const double *q, const double *qd, const double *qdd, const double *channels, double *tau);
 *   void @PREFIX@_step_at(struct @PREFIX@_state *state, const double *q, const double *qd, const double *qdd, const double *channels, double *tau);
";

/// The helper of Python.
const PYTHON_HELPER: &str = "

def channel(channels, at, reference):
    \"\"\"A further quantity of a sample; what the effect takes where it is not measured.\"\"\"
    value = None if channels is None else channels.get(CHANNELS[at])
    return reference if value is None else float(value)
";

impl SourceChannels {
    /// Quantities by their names, in the order in which effects have them.
    pub fn of(model: &FinalModel) -> Self {
        let mut list: Vec<SourceChannel> = Vec::new();
        let own = model.terms.iter().filter_map(|t| t.effect.own());
        for channel in own.flat_map(|own| &own.definition().channels) {
            if !list.iter().any(|c| c.name == channel.name) {
                list.push(SourceChannel {
                    name: channel.name.clone(),
                    unit: channel.unit.clone(),
                });
            }
        }
        Self(list)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The value of a quantity in a statement.
    pub fn value(&self, channel: &ChannelVariable) -> String {
        let at = self.0.iter().position(|c| c.name == channel.name).unwrap_or(0);
        format!("channel(channels, {at}, {:?})", channel.reference)
    }

    /// Lines for the top of a file.
    pub fn heading(&self, how: &str) -> Option<String> {
        let one = |c: &SourceChannel| format!("{} ({})", c.name, one_line(&c.unit));
        let names: Vec<String> = self.0.iter().map(one).collect();
        (!self.is_empty()).then(|| format!("Further quantities that effects depend on: {}. {how}", names.join(", ")))
    }

    /// The template of C with the argument, or without one.
    pub fn in_c(&self, text: &str, has_memory: bool) -> String {
        let with = |text: &str| if self.is_empty() { String::new() } else { text.to_string() };
        let of_memory = |text: &str| if has_memory { with(text) } else { String::new() };
        let count = format!("enum {{ CHANNELS = {} }};\n{C_HELPER}", self.0.len());
        text.replace("@AT@", &with("_at"))
            .replace("@CHANNELS@", &with(" const double *channels,"))
            .replace("@PASS@", &with(" channels,"))
            .replace("@PASS_ROW@", &with(" channels ? channels + s * CHANNELS : NULL,"))
            .replace("@UNUSED@", &with("    (void)channels;\n"))
            .replace("@CHANNEL_HELPER@", &with(&count))
            .replace("@OVERLOADS@", &with(C_OVERLOADS))
            .replace("@MEMORY_OVERLOADS@", &of_memory(C_MEMORY_OVERLOADS))
            .replace(
                "@CHANNEL_DECLARATIONS@",
                &(with(C_DECLARATIONS) + &of_memory(C_MEMORY_DECLARATIONS)),
            )
    }

    /// The template of Python with the argument, or without one.
    pub fn in_python(&self, text: &str) -> String {
        let with = |text: &str| if self.is_empty() { String::new() } else { text.to_string() };
        let mut helper = String::new();
        let names: Vec<String> = self.0.iter().map(|c| serde_json::to_string(&c.name).expect("text")).collect();
        let _ = write!(helper, "CHANNELS = [{}]\n{PYTHON_HELPER}", names.join(", "));
        text.replace("@CHANNELS@", &with(", channels=None"))
            .replace("@PASS@", &with(", channels"))
            .replace("@PASS_ROW@", &with(", _row(channels, s)"))
            .replace("@CHANNEL_ROWS@", &with(PYTHON_ROWS))
            .replace("@CHANNEL_HELPER@", &with(&helper))
    }
}

/// Of a dictionary of series, the values of one sample.
const PYTHON_ROWS: &str = "

def _row(channels, s):
    return None if channels is None else {name: values[s] for name, values in channels.items()}
";
