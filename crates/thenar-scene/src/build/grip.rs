//! Grips of the scene's hands.

use super::Built;
use crate::format::{GripTable, GripWord, Hand, Scene};
use crate::grip::{GripHand, GripKind, Order, usual_force};
use crate::text::{Fault, Located};
use thenar_core::model::BodyId;
use thenar_core::shape::Shape;

/// With which pads press against each other where a scene does not say \[N\].
const EACH_OTHER: f64 = 1.0;

/// Makes the hands that grip something ready for it; `None` for the others.
pub fn add_all(built: &mut Built, scene: &Scene) -> Result<(), Fault> {
    for (k, hand) in scene.hand.iter().enumerate() {
        let grips = match hand.grip.first() {
            Some(first) => Some(Box::new(grips(built, k, hand, first)?)),
            None => None,
        };
        built.grips.push(grips);
    }
    Ok(())
}

fn grips(
    built: &Built,
    k: usize,
    table: &Hand,
    first: &Located<GripTable>,
) -> Result<GripHand, Fault> {
    let hand = &built.hands[k];
    if !hand.driven {
        return Err(first.fault("a hand with `driven = false` grips nothing"));
    }
    let Some(flesh) = hand.flesh() else {
        return Err(first.fault("a hand with `flesh = false` touches nothing, and grips nothing"));
    };
    let mut gripping = GripHand::new(hand, built.world.rigids.len()).map_err(|e| first.fault(e))?;
    let mut free_from = Some(0.0);
    for grip in &table.grip {
        let GripTable { object, kind, force, at, open } = &grip.value;
        if open.is_some_and(|open| open <= *at) {
            return Err(grip.fault("expected an `open` later than `at`"));
        }
        match free_from {
            Some(free) if *at >= free => {}
            Some(free) => {
                return Err(grip.fault(format!(
                    "a hand grips one thing at a time: the grip before opens at {free} s, this one begins at {at} s"
                )));
            }
            None => {
                return Err(grip.fault(
                    "a hand grips one thing at a time: the grip before this one has no `open`",
                ));
            }
        }
        free_from = *open;
        let body = match object {
            Some(name) => {
                let body = built.names.body(name)?;
                grippable(built, k, name, body)?;
                if matches!((*kind, body), (GripWord::Hook, BodyId::Soft(_))) {
                    return Err(name.fault(format!(
                        "\"{}\" is soft: a hook bends around rigid handles",
                        name.value
                    )));
                }
                Some(body)
            }
            None if *kind == GripWord::Hook => {
                return Err(grip.fault(
                    "a hook bends around an `object`, and none is named; pads press against each other in the other kinds",
                ));
            }
            None => None,
        };
        let kind = of_word(*kind);
        gripping.learn(hand, kind).map_err(|e| grip.fault(e))?;
        let adapts = force.is_none() && body.is_some() && kind.has_thumb();
        let force = force.unwrap_or_else(|| {
            body.map_or(EACH_OTHER, |body| usual_force(&built.world, flesh, body, kind))
        });
        gripping.plan(Order::new(body, kind, force, *at, *open).adapting(adapts));
    }
    Ok(gripping)
}

/// Refuses what cannot be gripped whatever its size.
fn grippable(built: &Built, k: usize, name: &Located<String>, body: BodyId) -> Result<(), Fault> {
    let hand = &built.hands[k];
    let own = match body {
        BodyId::Rigid(i) => hand.handle.bones.contains(&i),
        BodyId::Soft(i) => hand.flesh() == Some(i),
    };
    if own {
        return Err(name.fault(format!("\"{}\" is the hand itself", name.value)));
    }
    let BodyId::Rigid(i) = body else { return Ok(()) };
    match &built.world.rigids[i as usize].shape {
        None => Err(name.fault(format!("\"{}\" has no shape: it touches nothing", name.value))),
        Some(Shape::HalfSpace) => {
            Err(name.fault(format!("\"{}\" is a plane, which has no two sides", name.value)))
        }
        Some(_) => Ok(()),
    }
}

fn of_word(word: GripWord) -> GripKind {
    match word {
        GripWord::Pinch => GripKind::Pinch,
        GripWord::Tripod => GripKind::Tripod,
        GripWord::Power => GripKind::Power,
        GripWord::Hook => GripKind::Hook,
        GripWord::Lateral => GripKind::Lateral,
    }
}
