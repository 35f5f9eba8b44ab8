//! Many inputs on several processes.

use super::case::Recipe;
use super::child::files_of;
use super::runner::{Order, Runner, Verdict};
use super::tally::{Tally, signature};
use super::target::Target;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Which inputs, and how.
#[derive(Debug, Clone, clap::Args)]
pub struct Campaign {
    /// How many; without an end if left out.
    #[arg(long)]
    pub inputs: Option<u64>,
    /// Number of the first.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// One target instead of all.
    #[arg(long)]
    pub target: Option<String>,
    /// Processes side by side.
    #[arg(long, default_value_t = 2)]
    pub processes: usize,
    /// Where the files of failed inputs go.
    #[arg(long, default_value = "target/fuzz")]
    pub failures: PathBuf,
}

/// Targets by turns: whole identifications and what is read on the way to them make up half.
pub const TURNS: [Target; 21] = {
    use Target::*;
    [
        Identify,
        BaseParameters,
        Inspect,
        Excite,
        Validate,
        Identify,
        BaseParameters,
        Motion,
        Inspect,
        Simulate,
        Identify,
        BaseParameters,
        Excite,
        Motion,
        Validate,
        Identify,
        BaseParameters,
        Inspect,
        Simulate,
        Settings,
        Model,
    ]
};

impl Campaign {
    fn recipe(&self, number: u64) -> Recipe {
        let seed = self.seed + number;
        let target = self
            .target
            .as_deref()
            .map(|name| Target::named(name).expect("a known target"));
        Recipe::of_seed(target.unwrap_or(TURNS[(seed % TURNS.len() as u64) as usize]), seed)
    }

    /// Runs to the end, or until interrupted.
    pub fn run(&self, stop: &AtomicBool) -> Tally {
        let next = AtomicU64::new(0);
        let tally = Mutex::new(Tally::default());
        std::thread::scope(|scope| {
            for _ in 0..self.processes {
                scope.spawn(|| self.work(&next, &tally, stop));
            }
        });
        tally.into_inner().expect("no thread has panicked")
    }

    fn work(&self, next: &AtomicU64, tally: &Mutex<Tally>, stop: &AtomicBool) {
        let mut runner = Runner::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if self.inputs.is_some_and(|most| number >= most) || stop.load(Ordering::Relaxed) {
                return;
            }
            let recipe = self.recipe(number);
            let verdict = runner.run(&Order::Recipe(&recipe));
            let first = tally
                .lock()
                .expect("no thread has panicked")
                .add(recipe.target, &verdict, Some(&recipe));
            if first {
                let failure = verdict.failure.clone().unwrap_or_default();
                eprintln!("input {} ({}): {failure}", self.seed + number, recipe.target.name());
                self.keep(&mut runner, &recipe, &verdict);
            }
            if number % 1000 == 999 {
                eprintln!(
                    "{} inputs\n{}",
                    number + 1,
                    tally.lock().expect("no thread has panicked").describe()
                );
            }
        }
    }

    /// Keeps the files of a failed input, with as few changes as fail alike.
    fn keep(&self, runner: &mut Runner, recipe: &Recipe, verdict: &Verdict) {
        let Some(failure) = &verdict.failure else { return };
        let least = shrunk(runner, recipe, failure);
        // Lays out the files once more: what was tried last may have been another.
        runner.run(&Order::Recipe(&least));
        let kind: String = signature(failure)
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
            .take(70)
            .collect();
        let folder = self.failures.join(recipe.target.name()).join(kind);
        let copied = copy(&runner.input(), &folder)
            .and_then(|()| std::fs::write(folder.join("why"), format!("{failure}\n{}\n", least.to_json())));
        if let Err(e) = copied {
            eprintln!("cannot keep {}: {e}", folder.display());
        }
    }
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    let _ = std::fs::remove_dir_all(to);
    std::fs::create_dir_all(to)?;
    files_of(from)
        .into_iter()
        .try_for_each(|(name, content)| std::fs::write(to.join(name), content))
}

/// The recipe without the changes that the failure does not need.
pub fn shrunk(runner: &mut Runner, recipe: &Recipe, failure: &str) -> Recipe {
    let wanted = signature(failure);
    let mut least = recipe.clone();
    let mut index = 0;
    while index < least.genes.len() {
        let fewer = least.without(index);
        let verdict = runner.run(&Order::Recipe(&fewer));
        match verdict.failure.is_some_and(|f| signature(&f) == wanted) {
            true => least = fewer,
            false => index += 1,
        }
    }
    least
}
