//! Named quantities of a law that nobody is going to ask for.
//!
//! What no sweep, rate or answer reads either is written all the same, by a kernel that knows nothing of it: to one
//! array for all of them, of which a chunk then writes the same few lines of the cache over and over. The others are
//! given back. A sweep of which nothing at all is read does not run.
use super::{Engine, Home};
use crate::spec::{SlotKind, Stage};
use std::collections::BTreeSet;

impl Engine {
    /// From now on [`Engine::named`] knows those quantities alone for which `keep` holds, and what the law needs itself.
    /// Forces, rates, energies and histories keep their bits. What has been left out before stays out.
    pub fn keep_named(&mut self, keep: &dyn Fn(&str) -> bool) {
        let mut read: BTreeSet<usize> = self.asked().into_iter().collect();
        let kept = self.spec.named.iter().filter(|(name, _)| keep(name));
        let kept = kept.flat_map(|(_, slots)| slots).map(|k| *k as usize);
        read.extend(kept.filter(|k| !self.unread.contains(k)));
        // Who reads runs behind who writes.
        for p in self.programs.iter_mut().rev() {
            let writes = p.kills || p.writes.contains(&true);
            p.unread = !writes && !p.out.iter().any(|slot| read.contains(slot));
            if !p.unread {
                read.extend(p.own.iter().chain(&p.nbr));
            }
        }
        let named: BTreeSet<u32> = self.spec.named.iter().flat_map(|n| n.1.clone()).collect();
        // The first two stages have run: what they have written stays.
        let again = |k: &usize| {
            let slot = &self.spec.slots[*k];
            let computed = matches!(
                slot.kind,
                SlotKind::Computed(stage) if !matches!(stage, Stage::Reference | Stage::Part)
            );
            computed && slot.part.is_none()
        };
        let unread = named.into_iter().map(|k| k as usize);
        let unread = unread.filter(|k| !read.contains(k)).filter(again);
        // Those of an earlier call share an array already.
        let mut shared = self.unread.first().map(|slot| self.homes[*slot]);
        for slot in unread.collect::<Vec<usize>>() {
            let Home::Array(a) = self.homes[slot] else {
                continue;
            };
            let home = *shared.get_or_insert(Home::Array(a));
            if home != Home::Array(a) {
                self.arrays[a] = vec![];
            }
            self.homes[slot] = home;
            self.unread.insert(slot);
        }
    }

    /// Slots of what the law answers, and of what it steps and lays out.
    pub(super) fn asked(&self) -> Vec<usize> {
        let s = &self.spec;
        let rates = s.rates.iter().flat_map(|r| [Some(r.rate), r.damping]);
        let histories = s.histories.iter().filter_map(|h| h.slot);
        let answers = s.force.iter().chain(&s.tangent).chain(&s.energy);
        let slots = answers.chain(&s.after_step).copied();
        let slots = slots.chain(rates.flatten()).chain(histories.map(|h| h.1));
        let slots = slots.chain(s.parts.iter().map(|part| part.slot));
        slots.map(|k| k as usize).collect()
    }

    /// Quantities that [`Engine::keep_named`] has left out.
    pub fn left_out(&self) -> impl Iterator<Item = &str> {
        let unread = |slots: &[u32]| slots.iter().any(|k| self.unread.contains(&(*k as usize)));
        let named = self.spec.named.iter();
        named
            .filter(move |(_, slots)| unread(slots))
            .map(|(name, _)| name.as_str())
    }
}
