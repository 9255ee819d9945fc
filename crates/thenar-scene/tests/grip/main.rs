//! Goal: grips by intent find their object, hold it with the force asked for, and tell what cannot
//! be had. Method: a thing on a peg between the fingers is gripped, lifted by 100 mm and held, for
//! shapes, hands and time steps; statics say what force, height and slip must be.

mod ask;
mod bits;
mod hook;
mod lateral;
mod mirror;
mod shapes;
mod stage;
mod survey;
