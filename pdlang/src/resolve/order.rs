//! The order in which the definitions of a model can be read, and what nothing needs.

use crate::ast::{self, Expr, Item, Model, Name, ResponseKind};
use crate::check;
use crate::diag::Diagnostic;
use crate::ir::Home;
use crate::resolve::declare::{declared, item_word};
use crate::resolve::walk::mentioned;
use std::collections::{HashMap, HashSet};

/// Definitions and weights such that each comes after those it mentions. What is part of a cycle, or declared twice,
/// is left out; cycles are reported.
pub(crate) fn order<'m>(model: &'m Model, report: &mut Vec<Diagnostic>) -> Vec<&'m Item> {
    let graph = Graph::of(model);
    let mut visits = Visits {
        state: vec![State::New; graph.items.len()],
        done: Vec::new(),
    };
    for start in 0..graph.items.len() {
        visits.from(start, &graph, report);
    }
    visits.done.into_iter().map(|k| graph.items[k]).collect()
}

struct Graph<'m> {
    items: Vec<&'m Item>,
    names: Vec<&'m Name>,
    needs: Vec<Vec<usize>>,
}

impl<'m> Graph<'m> {
    fn of(model: &'m Model) -> Self {
        let mut index = HashMap::new();
        let (mut items, mut names, mut exprs) = (Vec::new(), Vec::new(), Vec::new());
        for item in &model.items {
            if let Some((name, expr)) = defined(item)
                && !index.contains_key(name.text.as_str())
            {
                index.insert(name.text.as_str(), items.len());
                items.push(item);
                names.push(name);
                exprs.push(expr);
            }
        }
        let needs = exprs.into_iter().map(|expr| needs(expr, &index)).collect();
        Graph {
            items,
            names,
            needs,
        }
    }
}

/// The name and the expression of a definition or a weight.
fn defined(item: &Item) -> Option<(&Name, &Expr)> {
    match item {
        Item::Definition(definition) => Some((&definition.name, &definition.expr)),
        Item::Weight(weight) => Some((&weight.name, &weight.expr)),
        _ => None,
    }
}

fn needs(expr: &Expr, index: &HashMap<&str, usize>) -> Vec<usize> {
    let mut names = Vec::new();
    mentioned(expr, &mut names);
    names
        .iter()
        .filter_map(|name| index.get(name.as_str()).copied())
        .collect()
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    New,
    Open,
    Done,
    /// In a cycle, which is reported.
    Cyclic,
}

struct Visits {
    state: Vec<State>,
    done: Vec<usize>,
}

impl Visits {
    /// Depth first, with an explicit stack: a chain of definitions may be as long as the file.
    fn from(&mut self, start: usize, graph: &Graph, report: &mut Vec<Diagnostic>) {
        if self.state[start] != State::New {
            return;
        }
        self.state[start] = State::Open;
        let mut path: Vec<(usize, usize)> = vec![(start, 0)];
        while let Some((node, edge)) = path.last_mut() {
            let (here, next) = (*node, graph.needs[*node].get(*edge).copied());
            *edge += 1;
            match next.map(|next| (next, self.state[next])) {
                None => {
                    path.pop();
                    self.close(here);
                }
                Some((next, State::New)) => {
                    self.state[next] = State::Open;
                    path.push((next, 0));
                }
                Some((next, State::Open)) => self.cycle(next, &path, graph, report),
                Some(_) => {}
            }
        }
    }

    fn close(&mut self, node: usize) {
        if self.state[node] == State::Open {
            self.state[node] = State::Done;
            self.done.push(node);
        }
    }

    fn cycle(
        &mut self,
        first: usize,
        path: &[(usize, usize)],
        graph: &Graph,
        report: &mut Vec<Diagnostic>,
    ) {
        let from = path
            .iter()
            .position(|(node, _)| *node == first)
            .unwrap_or(0);
        let members: Vec<usize> = path[from..].iter().map(|(node, _)| *node).collect();
        let chain: Vec<&Name> = members.iter().map(|node| graph.names[*node]).collect();
        report.push(check::cycles::definitions(&chain));
        members
            .into_iter()
            .for_each(|node| self.state[node] = State::Cyclic);
    }
}

/// Warns of items that no response, break, update or node value needs, directly or not. Node values are
/// outputs in their own right, and so are fields with a rate; a field without one is a coefficient.
pub(crate) fn unused(model: &Model, report: &mut Vec<Diagnostic>) {
    let needed = needed(model);
    for item in &model.items {
        let is_output = match item {
            Item::Definition(definition) => definition.home == Home::Node,
            Item::Field(field) => has_rate(model, &field.name),
            Item::History(_) => true,
            _ => false,
        };
        if let Some(name) = declared(item).filter(|name| !is_output && !needed.contains(&name.text))
        {
            report.push(check::unused::warning(item_word(item), name));
        }
    }
}

fn has_rate(model: &Model, field: &Name) -> bool {
    model.items.iter().any(|item| {
        matches!(item, Item::Response(r) if r.kind == ResponseKind::Rate && r.name.text == field.text)
    })
}

fn needed(model: &Model) -> HashSet<String> {
    let mut queue = Vec::new();
    for item in &model.items {
        match item {
            Item::Response(response) => {
                mentioned(&response.expr, &mut queue);
                queue.extend(response.family.iter().map(|name| name.text.clone()));
            }
            Item::Break(breaking) => {
                mentioned(&breaking.when, &mut queue);
                queue.extend(breaking.family.iter().map(|name| name.text.clone()));
            }
            Item::Update(update) => mentioned(&update.expr, &mut queue),
            Item::AfterStep(after) => mentioned(&after.expr, &mut queue),
            Item::Field(ast::Field {
                lives: Some(when), ..
            }) => mentioned(when, &mut queue),
            Item::History(history) => {
                queue.extend(history.family.iter().map(|name| name.text.clone()))
            }
            Item::Definition(definition) if definition.home == Home::Node => {
                mentioned(&definition.expr, &mut queue)
            }
            _ => {}
        }
    }
    let mut needed = HashSet::new();
    let behind: HashMap<&str, &Expr> = model.items.iter().filter_map(behind).collect();
    while let Some(name) = queue.pop() {
        if let Some(expr) = behind
            .get(name.as_str())
            .filter(|_| !needed.contains(&name))
        {
            mentioned(expr, &mut queue);
        }
        needed.insert(name);
    }
    needed
}

/// The expression that a name stands for.
fn behind(item: &Item) -> Option<(&str, &Expr)> {
    match item {
        Item::Family(family) => Some((&family.name.text, &family.filter)),
        _ => defined(item).map(|(name, expr)| (name.text.as_str(), expr)),
    }
}
