//! The terms of effects, from what the effects say of themselves: with `glossary.json` they are the glossary of the pages.

use crate::effects::{About, Effect, Law, all, own};
use serde::{Serialize, Serializer};
use std::sync::LazyLock;

/// Name of the file that pages read.
pub(super) const NAME: &str = "effects.json";

/// A topic as `glossary.json` has them.
#[derive(Serialize)]
struct Topic {
    topic: &'static str,
    part: &'static str,
    mentions: bool,
    /// Phrases of sentences, and the term of each.
    #[serde(serialize_with = "as_map")]
    aliases: Vec<(String, String)>,
    /// Name and explanation by key.
    #[serde(serialize_with = "as_map")]
    terms: Vec<(String, [&'static str; 2])>,
}

/// In the order of the list.
fn as_map<T: Serialize, S: Serializer>(pairs: &[(String, T)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(pairs.iter().map(|(key, value)| (key, value)))
}

/// The file.
pub(super) static EFFECTS: LazyLock<String> = LazyLock::new(|| serde_json::to_string(&[topic()]).expect("text is JSON"));

fn topic() -> Topic {
    let key = |effect: &dyn Effect| (format!("effect_{}", effect.code()), effect.about());
    let law: &dyn Effect = &Law;
    let listed = all().iter().map(|effect| key(*effect));
    let each: Vec<(String, About)> = listed.chain([key(law), ("own_effect".into(), own::ABOUT)]).collect();
    Topic {
        topic: "Effects",
        part: "diagnosis",
        mentions: true,
        aliases: each
            .iter()
            .filter_map(|(key, about)| Some((alias(about)?, key.clone())))
            .collect(),
        terms: each
            .iter()
            .map(|(key, about)| (key.clone(), [about.name, about.meaning]))
            .collect(),
    }
}

/// The phrase without its article, where it is another than the name.
fn alias(about: &About) -> Option<String> {
    let phrase = about.phrase.to_lowercase();
    let bare = ["a ", "an "].iter().find_map(|article| phrase.strip_prefix(article));
    let bare = bare.unwrap_or(&phrase);
    (bare != about.name.to_lowercase()).then(|| bare.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_effect_is_a_term_and_its_phrase_leads_there() {
        let read: serde_json::Value = serde_json::from_str(&EFFECTS).expect("JSON");
        for effect in all() {
            let (key, about) = (format!("effect_{}", effect.code()), effect.about());
            let term = &read[0]["terms"][&key];
            assert_eq!(term[0], about.name);
            assert!(
                term[1].as_str().is_some_and(|text| text.ends_with('.') && text.len() > 20),
                "{key}"
            );
            let words = about.phrase.to_lowercase();
            let mut known = read[0]["aliases"].as_object().expect("an object").keys();
            let named = words.ends_with(&about.name.to_lowercase());
            assert!(named || known.any(|alias| words.ends_with(alias)), "{key}: {words}");
        }
    }
}
