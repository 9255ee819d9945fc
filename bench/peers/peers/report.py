"""The outcome as Markdown, and the machine it was found on."""

import os
import platform
import subprocess
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

from .cases import BAR_LINEAR, BAR_REFINED, CASES, REFERENCE_STEP

DASH = "–"


def machine(root):
    """What the figures depend on besides the code."""
    return {
        "cpu": cpu(),
        "cores": os.cpu_count(),
        "load_at_start": round(os.getloadavg()[0], 1),
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "rustc": said("rustc", "--version"),
        "thenar": said("git", "-C", str(root), "describe", "--always", "--dirty"),
        "rapier3d": locked(root / "Cargo.lock", "rapier3d"),
        "mujoco": metadata.version("mujoco"),
    }


def machine_in_words(root, crate):
    """The same for a section of its own, with the crate that it compares."""
    load = os.getloadavg()[0]
    busy = " (**busy: the times are upper bounds**)" if load > 0.7 else ""
    return (
        f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC; {cpu()}, {os.cpu_count()} cores, "
        f"load {load:.1f} at the start{busy}; {platform.system()} {platform.release()}; "
        f"Thenar {said('git', '-C', str(root), 'describe', '--always')}, "
        f"{crate} {locked(root / 'Cargo.lock', crate)}; {said('rustc', '--version')}.\n"
    )


def renew(file, title, section):
    """Puts a section in the place of the one with this title, or at the end."""
    before, _, after = file.read_text(encoding="utf-8").partition(title)
    start = after.find("\n## ")
    rest = after[start:] if start >= 0 else ""
    file.write_text(f"{before.rstrip()}\n\n{section}{rest}", encoding="utf-8")


def cpu():
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def said(*command):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def locked(file, crate):
    lines = file.read_text(encoding="utf-8").splitlines()
    at = lines.index(f'name = "{crate}"')
    return lines[at + 1].split('"')[1]


def number(value, digits=3):
    if value is None:
        return DASH
    if value != 0 and abs(value) < 10.0**-digits:
        return f"{value:.0e}"
    return f"{value:.{digits}f}"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def milliseconds(step):
    return f"{step * 1e3:.3g}"


SHARED = [
    ("step [ms]", lambda r: milliseconds(r["step"])),
    ("engine", lambda r: r["engine"]),
    ("ms per step", lambda r: number(r.get("median"))),
    ("p99", lambda r: number(r.get("p99"))),
    ("nodes off, rms [mm]", lambda r: r["failure"] or number(r.get("nodes_rms"))),
    ("nodes off, max", lambda r: number(r.get("nodes_max"), 2)),
    ("tie stretch, rms [mm]", lambda r: number(r.get("stretch_rms"))),
]
BONES = [
    ("bones off, rms [mm]", lambda r: number(r.get("bones_rms"))),
    ("joint gap [mm]", lambda r: number(r.get("joint_gap_max"), 4)),
]
CONTACT = [
    ("step [ms]", lambda r: milliseconds(r["step"])),
    ("engine", lambda r: r["engine"]),
    ("penetration held / max [mm]", lambda r: pair(r, "penetration_held", "penetration_max", 2)),
    ("load by drive and weight [N]", lambda r: number(r.get("load"), 2)),
    ("table's force / load", lambda r: number(r.get("force_over_load"))),
    ("unsteady", lambda r: percent(r.get("force_unsteady"))),
    ("friction / load (0.6)", lambda r: number(r.get("friction_over_load"))),
    ("palm pushed back [mm]", lambda r: number(r.get("palm_lag"), 2)),
    ("contacts", lambda r: number(r.get("contacts"), 0)),
]


def pair(row, first, second, digits):
    return f"{number(row.get(first), digits)} / {number(row.get(second), digits)}"


def percent(value):
    return DASH if value is None else f"{100 * value:.1f} %"


def laid_out(columns, rows):
    return table([c[0] for c in columns], [[c[1](row) for c in columns] for row in rows])


def markdown(found, preface):
    parts = [preface, machine_lines(found), hand_line(found["hand"]), speed_summary(found)]
    for case in CASES:
        rows = found["cases"].get(case.name)
        if rows is None:
            continue
        notes = found["references"][case.name]
        parts.append(f"## {case.title[0].upper()}{case.title[1:]}\n")
        parts.append(reference_line(notes))
        parts.append(laid_out(SHARED + (BONES if case.name != "flesh" else []), rows))
        if case.name == "press":
            parts.append(
                f"Reference: penetration {number(notes['penetration_held'])} mm, load "
                f"{notes['load']:.2f} N, friction / load {notes['friction_over_load']:.3f}, "
                f"palm pushed back {notes['palm_lag']:.2f} mm.\n"
            )
            parts.append(laid_out(CONTACT, rows))
    parts += [bar_section(found["bar"]), stability_section(found["stability"])]
    return "\n".join(part for part in parts if part)


def machine_lines(found):
    m = found["machine"]
    return (
        f"{found['date']}; {m['cpu']}, {m['cores']} cores, load {m['load_at_start']} at the start"
        f"{' (**busy: the times are upper bounds**)' if m['load_at_start'] > 0.7 else ''}; "
        f"{m['system']}; Thenar {m['thenar']}, Rapier {m['rapier3d']}, MuJoCo {m['mujoco']}; "
        f"{m['rustc']}, Python {m['python']}. Processor time of one thread, "
        f"{found['repeats']} repeat(s) in turn, of each step the quickest; {found['took']:.0f} s in all.\n"
    )


def hand_line(hand):
    return (
        f"The hand: {hand['tets']} tetrahedra, {hand['nodes']} nodes, {hand['ties']} of them tied, "
        f"{hand['mass'] * 1e3:.0f} g, 16 bones, 15 joints.\n"
    )


def speed_summary(found):
    """Milliseconds per step of every case, engines side by side."""
    names, rows = [], []
    for name, found_rows in found["cases"].items():
        for row in found_rows:
            if row["engine"] not in names:
                names.append(row["engine"])
    for name, found_rows in found["cases"].items():
        for step in sorted({row["step"] for row in found_rows}):
            here = {row["engine"]: row for row in found_rows if row["step"] == step}
            cells = [cell(here.get(engine)) for engine in names]
            rows.append([name, milliseconds(step), *cells])
    head = ["case", "step [ms]", *names]
    return "## Milliseconds per step (and how far nodes are off, rms)\n\n" + table(head, rows)


def cell(row):
    if row is None:
        return DASH
    if row["failure"]:
        return row["failure"]
    return f"{row['median']:.2f} ({number(row.get('nodes_rms'), 2)} mm)"


def reference_line(notes):
    text = (
        f"Reference: Thenar's monolithic solver at {REFERENCE_STEP * 1e3:.2g} ms, "
        f"velocity tolerance 1e-8 m/s; tie stretch there {number(notes['stretch_rms'])} mm"
    )
    if notes.get("mujoco_rms") is not None:
        text += (
            f"; MuJoCo at the same small step differs from it by {notes['mujoco_rms']:.3f} mm rms"
        )
    return text + ".\n"


def bar_section(rows):
    head = [
        "engine",
        "ms per step",
        "end sinks by [mm]",
        "off the linear element's answer",
        "off the refined answer",
    ]
    cells = [
        [
            row["engine"],
            number(row.get("median")),
            row["failure"] or f"{row['deflection']:.4f}",
            percent(row.get("linear_error")),
            percent(row.get("refined_error")),
        ]
        for row in rows
    ]
    return (
        "## (d) Cantilever, 240 tetrahedra\n\n"
        f"Known from elsewhere: {BAR_LINEAR} mm with these linear elements, which lock; "
        f"{BAR_REFINED} mm refined. All three use linear tetrahedra, as in the hand; MuJoCo's other "
        "elements fill boxes of cells, and would glue a hand's fingers together.\n\n"
        + table(head, cells)
    )


def stability_section(rows):
    names = list(dict.fromkeys(row["engine"] for row in rows))
    steps = sorted({row["step"] for row in rows})
    found = {(row["engine"], row["step"]): row["held"] for row in rows}
    cells = [
        [name, *(f"{found[name, s]:.0e}" if found[name, s] else "none" for s in steps)]
        for name in names
    ]
    return (
        "## Largest stable coupling\n\n"
        "As a multiple of the shipped 2e9 N/m⁴ (tried: 1, 1e2, 1e4, 1e6), hand dropped into its own "
        "weight for 0.3 s: no failure, no growing energy, no tie stretched beyond 20 mm.\n\n"
        + table(["engine", *(f"{milliseconds(s)} ms" for s in steps)], cells)
    )
