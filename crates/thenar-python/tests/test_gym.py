"""Goal: the environment keeps Gymnasium's rules, and can be solved. Method: Gymnasium's own checker; a hand that is led
along the scene's way of grasping."""

import warnings

import numpy as np
import numpy.typing as npt
import pytest
from gymnasium.utils.env_checker import check_env

import thenar.gym
from thenar.gym import ANGLE_STEP, STEPS, WRIST_STEP, Lift

Array = npt.NDArray[np.float64]


@pytest.fixture(scope="module")
def lift() -> Lift:
    return Lift()


def test_the_rules_of_gymnasium_are_kept(lift: Lift) -> None:
    with warnings.catch_warnings():
        # It has no registration, and its observations have no bounds.
        warnings.filterwarnings("ignore", message=".*(infinity|spec|render).*")
        check_env(lift, skip_render_check=True)


def degrees(thumb: list[float], *fingers: list[float]) -> Array:
    """Twenty angles: base flexion and spread, then two flexions, of each finger [rad]."""
    angles: Array = np.radians(np.array([thumb, *fingers]).ravel())
    return angles


#: Open around the loaf, and closed on it: the scene's own keys.
OPEN = degrees([-14, 22, 2, 2], [38, 0, 12, 8], [40, 0, 12, 8], [40, 0, 12, 8], [36, 0, 12, 8])
CLOSED = degrees([14, 22, 14, 18], [58, 0, 18, 10], [66, 0, 18, 12], [66, 0, 20, 12], [60, 0, 20, 12])


def goal(step: int) -> tuple[Array, Array]:
    """Where wrist and angles are to be: down, closed, up."""
    if step < 75:
        return np.array([0.066, 0.099, 0.07]), OPEN
    if step < 130:
        return np.array([0.066, 0.099, 0.07]), CLOSED
    return np.array([0.066, 0.19, 0.07]), CLOSED


def episode(lift: Lift, seed: int, close: bool) -> tuple[list[float], bool, bool, list[bytes]]:
    """Rewards, whether it was terminated and truncated, and the bytes of all observations."""
    seen, info = lift.reset(seed=seed)
    rewards: list[float] = []
    bits = [seen.tobytes()]
    done = cut = False
    while not (done or cut):
        place, angles = goal(len(rewards))
        angles = angles if close else OPEN
        wanted = seen[23:46]
        speed = 0.35  # of the largest, for the wrist
        action = np.concatenate(
            [np.clip((place - wanted[:3]) / WRIST_STEP, -speed, speed), (angles - wanted[3:]) / ANGLE_STEP * 0.2]
        )
        seen, reward, done, cut, info = lift.step(np.clip(action, -1.0, 1.0))
        rewards.append(float(reward))
        bits.append(seen.tobytes())
    assert info["is_success"] == done
    return rewards, done, cut, bits


def test_a_grasp_lifts_the_bread_and_ends_the_episode(lift: Lift) -> None:
    rewards, done, cut, _ = episode(lift, 3, close=True)
    assert done and not cut and len(rewards) < STEPS and rewards[0] == 0.0
    assert rewards[-30:-1] == [1.0] * 29
    assert rewards[-1] == 1.0 + STEPS - len(rewards)


def test_an_open_hand_lifts_nothing_until_the_episode_is_cut_off(lift: Lift) -> None:
    rewards, done, cut, _ = episode(lift, 3, close=False)
    assert cut and not done and len(rewards) == STEPS
    assert max(rewards[150:]) < 0.2


def test_the_same_seed_gives_the_same_bits_and_another_does_not(lift: Lift) -> None:
    first = episode(lift, 5, close=True)[3]
    assert episode(lift, 6, close=True)[3] != first
    assert episode(Lift(), 5, close=True)[3] == first
