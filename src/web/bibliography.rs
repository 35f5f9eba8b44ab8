//! The bibliography of the documentation, for the help page.

use serde::Serialize;
use std::sync::LazyLock;

/// Name of the file that the page reads.
pub(super) const NAME: &str = "bibliography.json";

const TEXT: &str = include_str!("../docs/bibliography.md");

/// What is published on a topic.
#[derive(Serialize)]
struct Topic {
    topic: &'static str,
    sources: Vec<Source>,
}

/// A publication; without `doi` where it has none.
#[derive(Serialize)]
struct Source {
    text: String,
    doi: Option<&'static str>,
}

/// The file.
pub(super) static SOURCES: LazyLock<String> = LazyLock::new(|| serde_json::to_string(&topics()).expect("text is JSON"));

/// Headings of the second level are topics, items of lists below them sources.
fn topics() -> Vec<Topic> {
    let parts = TEXT.split("\n## ").skip(1);
    let of = |part: &'static str| {
        let mut lines = part.lines();
        Topic {
            topic: lines.next().unwrap_or_default(),
            sources: lines.filter_map(|line| line.strip_prefix("- ")).map(source).collect(),
        }
    };
    parts.map(of).collect()
}

/// Titles of books and journals are set in italics in the documentation alone.
fn source(line: &'static str) -> Source {
    let (text, doi) = line.split_once(" doi:").map_or((line, None), |(text, doi)| (text, Some(doi)));
    Source {
        text: text.replace('*', ""),
        doi,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_line_of_the_bibliography_is_a_source() {
        let sources: Vec<Source> = topics().into_iter().flat_map(|t| t.sources).collect();
        assert_eq!(sources.len(), TEXT.lines().filter(|line| line.starts_with("- ")).count());
        for Source { text, doi } in sources {
            assert!(text.ends_with('.') && text.contains('('), "{text}");
            assert!(doi.is_none_or(|doi| doi.starts_with("10.") && doi.contains('/')), "{doi:?}");
        }
    }
}
