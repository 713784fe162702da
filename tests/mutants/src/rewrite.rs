//! Rewrites a file to contain all its mutants: every place becomes a choice by [`mutant_switch::at`].

use std::collections::{BTreeMap, HashMap, HashSet};

use anyhow::{Context, Result};

use crate::list::Mutant;
use crate::nodes::{Bytes, Kind, Node, nodes};

/// Everything refused by the compiler so far.
#[derive(Default)]
pub struct RefusedMutants {
    /// Mutants whose own code does not compile.
    pub mutants: HashSet<usize>,
    /// Places that cannot be written as a choice, by their first mutant; the value is the number of failed forms.
    pub places: HashMap<usize, u8>,
    /// Functions that are called from constants.
    pub constant: HashSet<String>,
}

impl RefusedMutants {
    /// Number of refusals.
    pub fn count(&self) -> usize {
        self.mutants.len() + self.constant.len() + self.places.values().map(|&forms| usize::from(forms)).sum::<usize>()
    }
}

/// A rewritten file.
pub struct Rewritten {
    pub text: String,
    /// Bytes of `text` that belong to one mutant.
    pub own: Vec<(Bytes, usize)>,
    /// Bytes of `text` of a whole place, by the place's first mutant.
    pub places: Vec<(Bytes, usize)>,
    /// Mutant → site and variant.
    pub switches: Vec<(usize, usize, u8)>,
    /// Mutants inside constants, or without a known place.
    pub left_out: Vec<usize>,
    /// Number of sites used by the file.
    pub sites: usize,
}

struct Writer<'a> {
    text: &'a str,
    nodes: &'a [Node],
    /// Node → mutants at that node.
    at: BTreeMap<usize, Vec<usize>>,
    mutants: &'a [Mutant],
    refused: &'a RefusedMutants,
    /// Constants that are replaced by a function at run time.
    functions: HashSet<String>,
    first_site: usize,
    out: Rewritten,
}

/// Rewrites one file. `mutants` are all mutants, `here` the numbers of those in this file; sites count from `first_site`.
pub fn rewrite(
    text: &str,
    mutants: &[Mutant],
    here: &[usize],
    refused: &RefusedMutants,
    first_site: usize,
) -> Result<Rewritten> {
    let nodes = nodes(text).context("parse")?;
    let out = Rewritten {
        text: String::with_capacity(4 * text.len()),
        own: Vec::new(),
        places: Vec::new(),
        switches: Vec::new(),
        left_out: Vec::new(),
        sites: nodes.len(),
    };
    let mut writer = Writer {
        text,
        nodes: &nodes,
        at: BTreeMap::new(),
        mutants,
        refused,
        functions: HashSet::new(),
        first_site,
        out,
    };
    for &number in here {
        match writer.place_of(&mutants[number]) {
            Some(node) => writer.at.entry(node).or_default().push(number),
            None => writer.out.left_out.push(number),
        }
    }
    for node in &nodes {
        if let Kind::Constant { name, value, .. } = &node.kind
            && !refused.constant.contains(name)
            && writer.at.keys().any(|&n| value.start <= nodes[n].range.start && nodes[n].range.end <= value.end)
        {
            writer.functions.insert(name.clone());
        }
    }
    writer.render(0..text.len(), 0);
    Ok(writer.out)
}

impl Writer<'_> {
    /// The place of a mutant, unless it is in a constant or in a function that must remain constant.
    fn place_of(&self, mutant: &Mutant) -> Option<usize> {
        let fits = |node: &Node| match (mutant.genre.as_str(), &node.kind) {
            ("BinaryOperator", Kind::Binary { .. } | Kind::Assign { .. }) => node.anchor == mutant.start,
            ("UnaryOperator", Kind::Unary { .. }) => node.anchor == mutant.start,
            ("MatchArmGuard", Kind::Guard { .. }) => node.anchor == mutant.start,
            ("MatchArm", Kind::Guard { arm }) => *arm == mutant.start,
            ("MatchArm", Kind::Pattern) => node.anchor == mutant.start,
            ("StructField", Kind::Field { .. }) => node.anchor == mutant.start,
            ("FnValue", Kind::Body) => node.range.start < mutant.start && mutant.end <= node.range.end,
            _ => false,
        };
        let (number, node) = self.nodes.iter().enumerate().rfind(|(_, node)| fits(node))?;
        let kept = |other: &Node| match &other.kind {
            Kind::Const { function: name, body } | Kind::Constant { name, value: body, .. } => {
                body.start <= node.range.start && node.range.end <= body.end && self.refused.constant.contains(name)
            }
            _ => false,
        };
        (!node.constant && !self.nodes.iter().any(kept)).then_some(number)
    }

    fn render(&mut self, range: Bytes, from: usize) {
        let mut at = range.start;
        let mut number = from;
        while let Some(node) = self.nodes.get(number) {
            if node.range.start >= range.end {
                break;
            }
            if node.range.start < at || node.range.end > range.end {
                number += 1;
                continue;
            }
            let changed = match &node.kind {
                Kind::Const { .. } => true,
                Kind::Constant { name, .. } => self.functions.contains(name),
                Kind::Use { name } => !node.constant && self.functions.contains(name),
                _ => self.at.contains_key(&number),
            };
            if !changed {
                number += 1;
                continue;
            }
            let node = node.clone();
            self.out.text.push_str(&self.text[at..node.range.start]);
            self.place(number, &node);
            at = node.range.end;
            number += 1;
        }
        self.out.text.push_str(&self.text[at..range.end]);
    }

    fn place(&mut self, number: usize, node: &Node) {
        let begin = self.out.text.len();
        if let Kind::Const { function, body } = &node.kind {
            let mutated = self.at.keys().any(|&n| {
                let range = &self.nodes[n].range;
                body.start <= range.start && range.end <= body.end
            });
            if self.refused.constant.contains(function) || !mutated {
                self.out.text.push_str("const");
            }
            return;
        }
        if let Kind::Constant { name, of, value } = &node.kind {
            self.push(&self.text[node.range.clone()]);
            self.push(&format!(" #[allow(non_snake_case)] #[inline(always)] fn __{name}() -> {of} {{ "));
            self.render(value.clone(), number + 1);
            return self.push(" }");
        }
        if let Kind::Use { name } = &node.kind {
            return self.push(&format!("__{name}()"));
        }
        let here = self.at[&number].clone();
        let failed = self.refused.places.get(&here[0]).copied().unwrap_or(0);
        let forms = if matches!(node.kind, Kind::Binary { .. }) { 2 } else { 1 };
        let alive: Vec<usize> = here.iter().copied().filter(|m| !self.refused.mutants.contains(m)).collect();
        if failed >= forms || alive.is_empty() {
            if failed >= forms {
                self.out.left_out.extend(&alive);
            }
            return self.render(node.range.clone(), number + 1);
        }
        let site = self.first_site + number;
        for (variant, &mutant) in alive.iter().enumerate() {
            self.out.switches.push((mutant, site, variant as u8 + 1));
        }
        self.write(number, node, &alive, site, failed);
        self.out.places.push((begin..self.out.text.len(), here[0]));
    }

    fn push(&mut self, text: &str) {
        self.out.text.push_str(text);
    }

    /// `0 => …, 1 => …, _ => …`: the original code, then the code of each mutant, marked as its own.
    fn variants(&mut self, alive: &[usize], code: impl Fn(&Mutant) -> String) {
        for (variant, &mutant) in alive.iter().enumerate() {
            let last = variant + 1 == alive.len();
            self.push(&if last { "_ => ".to_string() } else { format!("{} => ", variant + 1) });
            let begin = self.out.text.len();
            self.push(&code(&self.mutants[mutant]));
            self.out.own.push((begin..self.out.text.len(), mutant));
            self.push(", ");
        }
    }

    fn write(&mut self, number: usize, node: &Node, alive: &[usize], site: usize, form: u8) {
        let at = format!("::mutant_switch::at({site})");
        let inside = number + 1;
        match &node.kind {
            Kind::Binary { left, op, right } => self.binary((left, op, right), alive, &at, inside, form),
            Kind::Assign { left, op, right } => {
                let op = self.text[op.clone()].to_string();
                self.push("(match ");
                self.render(right.clone(), inside);
                self.push(" { __r => { let __l = &mut (");
                self.render(left.clone(), inside);
                self.push(&format!("); match {at} {{ 0 => *__l {op} __r, "));
                self.variants(alive, |m| format!("*__l {} __r", m.replacement));
                self.push("} } })");
            }
            Kind::Unary { op, inner } => {
                let op = self.text[op.clone()].to_string();
                self.push("(match ");
                self.render(inner.clone(), inside);
                self.push(&format!(" {{ __l => match {at} {{ 0 => {op}__l, "));
                self.variants(alive, |_| "__l".to_string());
                self.push("} })");
            }
            Kind::Body => {
                self.push(&format!("{{ match {at} {{ 0 => {{}} "));
                self.variants(alive, |m| format!("return {}", m.replacement));
                self.push("} ");
                self.render(node.range.start + 1..node.range.end, inside);
            }
            Kind::Pattern => {
                self.render(node.range.clone(), inside);
                self.push(&format!(" if {at} == 0"));
                self.out.own.push((self.out.text.len() - 1..self.out.text.len(), alive[0]));
            }
            Kind::Guard { .. } => {
                self.push(&format!("match {at} {{ 0 => "));
                self.render(node.range.clone(), inside);
                self.push(", ");
                self.variants(alive, |m| if m.genre == "MatchArm" { "false".into() } else { m.replacement.clone() });
                self.push("}");
            }
            Kind::Field { member, base } => {
                let base = self.text[base.clone()].to_string();
                self.push(&format!("match {at} {{ 0 => "));
                self.render(node.range.clone(), inside);
                self.push(", ");
                self.variants(alive, |_| format!("({base}).{member}"));
                self.push("}");
            }
            Kind::Constant { .. } | Kind::Use { .. } | Kind::Const { .. } => {}
        }
    }

    fn binary(&mut self, parts: (&Bytes, &Bytes, &Bytes), alive: &[usize], at: &str, inside: usize, form: u8) {
        let (left, op, right) = parts;
        let op = self.text[op.clone()].to_string();
        if matches!(op.as_str(), "&&" | "||") {
            // Both in one `if`, so that the right side is not evaluated where the operator skips it.
            let unread = if op == "&&" { "!=" } else { "==" };
            self.push("(match ");
            self.render(left.clone(), inside);
            self.push(&format!(" {{ __l => if __l {unread} ({at} != 0) {{ "));
            self.render(right.clone(), inside);
            self.push(" } else { __l } })");
            return;
        }
        let by_reference = matches!(op.as_str(), "==" | "!=" | "<" | "<=" | ">" | ">=") && form == 0;
        let (open, star) = if by_reference { ("&(", "*") } else { ("(", "") };
        self.push(&format!("(match ({open}"));
        self.render(left.clone(), inside);
        self.push(&format!("), {open}"));
        self.render(right.clone(), inside);
        self.push(&format!(")) {{ (__l, __r) => match {at} {{ 0 => {star}__l {op} {star}__r, "));
        self.variants(alive, |m| format!("{star}__l {} {star}__r", m.replacement));
        self.push("} })");
    }
}
