"""A hand grasps a loaf of bread: prints what palm and fingers press with, ten times a second of its time."""

from __future__ import annotations

import thenar


def main(seconds: float = 2.0) -> list[list[float]]:
    """Runs for so long [s]; returns the rows printed, [N]."""
    world = thenar.Scene.named("bread-grasp").world()
    hand = world.hands[0]
    print("time [s] " + "".join(f"{part:>8}" for part in thenar.PARTS) + "  [N]")
    rows = []
    pause = round(0.1 / world.time_step)
    for _ in range(round(seconds / 0.1)):
        world.step(pause)
        forces = [float(force) for force in hand.loads["normal"]]
        print(f"{world.time:8.2f} " + "".join(f"{force:8.3f}" for force in forces))
        rows.append(forces)
    return rows


if __name__ == "__main__":
    main()
