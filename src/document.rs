//! What a job says, as values: sections of sentences, tables and plots. `report` has the views of them: terminal text, HTML, CSV, Markdown and SVG.

/// What values of other types become, a line a type.
macro_rules! becomes {
    ($to:ty { $($value:ident: $from:ty => $made:expr;)* }) => {$(
        impl From<$from> for $to {
            fn from($value: $from) -> Self {
                $made
            }
        }
    )*};
}

pub mod plot;
pub mod table;

use std::borrow::Cow;

use crate::checks::{Check, ITSELF, Outcome, verdict};
use crate::exit;
pub use plot::{Axis, Colour, Mark, Plot, Point, Shape, Style};
pub use table::{Cell, Column, Columns, Table, rounded};

/// A job's result for people.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    /// What the job does, as a heading.
    pub title: String,
    /// What its checks come to.
    pub verdict: Outcome,
    /// The answer, in one sentence.
    pub answer: String,
    /// In the order of the argument.
    pub sections: Vec<Section>,
    /// Every check that was planned, the skipped ones included.
    pub checks: Vec<Check>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    pub title: String,
    /// What is found, in a sentence or two; empty where the blocks say it.
    pub answer: String,
    pub blocks: Vec<Block>,
    /// Details, which a page folds away and a terminal leaves out.
    pub details: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A heading within the section.
    Heading(String),
    Text(String),
    Table(Table),
    /// A chart of numbers against numbers.
    Plot(Plot),
    /// Any other picture.
    Drawing(Drawing),
    /// What other pages say, side by side.
    Tiles(Vec<Tile>),
}

/// What another page of the same job says, in a few words.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    pub title: String,
    /// The figure that one remembers; may be empty.
    pub figure: String,
    pub words: String,
    /// The page's name, without its end.
    pub page: &'static str,
}

/// A picture that is no plot: a bed, a field, a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    pub caption: String,
    /// The picture, which needs nothing else.
    pub svg: String,
    /// What is drawn, as numbers; its name is the picture's.
    pub table: Table,
}

impl Document {
    /// With the verdict that its checks come to, without sections yet; without checks it only shows.
    pub fn new(title: impl Into<String>, answer: impl Into<String>, checks: Vec<Check>) -> Self {
        let verdict = match checks.is_empty() {
            true => Outcome::Pass,
            false => verdict(&checks),
        };
        Document {
            title: title.into(),
            verdict,
            answer: answer.into(),
            sections: Vec::new(),
            checks,
        }
    }

    #[must_use]
    pub fn with(mut self, sections: impl IntoIterator<Item = Section>) -> Self {
        self.sections.extend(sections);
        self
    }

    /// The verdict for people; none of a document that only shows.
    pub fn verdict_in_words(&self) -> Option<&'static str> {
        let shows = self.checks.is_empty() && self.verdict == Outcome::Pass;
        let said = match self.exit_code() {
            exit::ENGINE_FAILED => "Engine failed",
            // Of one run alone nothing is compared.
            exit::CHECK_FAILED if self.has_only("run/") => "Not to be relied on",
            // Nothing else was looked at.
            exit::AGREED if self.has_only(ITSELF) => "Consistent with itself",
            exit::CHECK_FAILED if self.has_only(ITSELF) => "Not consistent with itself",
            _ => self.verdict.verdict(),
        };
        (!shows).then_some(said)
    }

    /// Whether the ids of all checks begin so.
    fn has_only(&self, id: &str) -> bool {
        self.checks.iter().all(|check| check.id.starts_with(id))
    }

    /// What a job with this result tells a script; of an engine that gave nothing to judge this is not what a difference tells.
    pub fn exit_code(&self) -> u8 {
        let no_result = self.checks.iter().any(|check| check.engine_failed);
        match self.verdict {
            Outcome::Fail if no_result => exit::ENGINE_FAILED,
            verdict => verdict.exit_code(),
        }
    }

    /// Whether its page shows more than words and tables.
    pub fn has_pictures(&self) -> bool {
        let mut blocks = self.sections.iter().flat_map(|section| &section.blocks);
        blocks.any(|block| matches!(block, Block::Plot(_) | Block::Drawing(_)))
    }
}

impl Section {
    pub fn new(title: &str, answer: impl Into<String>) -> Self {
        Section {
            title: title.to_owned(),
            answer: answer.into(),
            blocks: Vec::new(),
            details: false,
        }
    }

    #[must_use]
    pub fn with(mut self, block: impl Into<Block>) -> Self {
        self.blocks.push(block.into());
        self
    }

    #[must_use]
    pub fn with_all(self, blocks: impl IntoIterator<Item = impl Into<Block>>) -> Self {
        blocks.into_iter().fold(self, Section::with)
    }

    #[must_use]
    pub fn as_details(mut self) -> Self {
        self.details = true;
        self
    }
}

becomes!(Block {
    table: Table => Block::Table(table);
    plot: Plot => Block::Plot(plot);
    drawing: Drawing => Block::Drawing(drawing);
    tiles: Vec<Tile> => Block::Tiles(tiles);
    text: String => Block::Text(text);
    text: &str => Block::Text(text.to_owned());
});

impl<T> From<Columns<T>> for Block {
    fn from(columns: Columns<T>) -> Self {
        Block::Table(columns.into())
    }
}

/// The text with what a terminal or a browser would obey written out, as `\u{202e}`: control characters but line ends and
/// tabs, what changes the direction of writing, and what no XML may hold. Names come from files that somebody made.
pub fn harmless(text: &str) -> Cow<'_, str> {
    let obeyed = |character: char| {
        character.is_control() && character != '\n' && character != '\t'
            || matches!(character, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
            || matches!(character, '\u{fffe}' | '\u{ffff}')
    };
    if !text.contains(obeyed) {
        return Cow::Borrowed(text);
    }
    let written = |letter: char| match obeyed(letter) {
        true => letter.escape_unicode().to_string(),
        false => letter.to_string(),
    };
    text.chars().map(written).collect()
}
