//! The example does what it says.

#[allow(dead_code)]
#[path = "../examples/grip.rs"]
mod grip;

#[test]
fn the_example_grips_its_ball_and_lifts_it() {
    let (lift, sim) = grip::lift().unwrap();
    assert!((lift - 0.08).abs() < 0.006, "{lift} m of 0.08 m");
    let hand = sim.hands().next().unwrap();
    let loads = sim.loads(hand);
    // Thumb and index finger hold it with the force that was asked for.
    for k in [1, 2] {
        assert!((loads[k].normal - 2.0).abs() < 0.4, "{loads:?}");
    }
    assert!(sim.hand(hand).grip_trouble().is_none());
}
