"""What the report of the paper's tests shows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from multilift import provenance, report
from multilift.models.planar import quantities
from multilift.models.planar.run import PlanarRun
from multilift.models.planar.scenario import PlanarScenario
from multilift.paper import claims
from multilift.styles import LAW_LABELS

#: The paper's figures of each test: response, commands.
FIGURES: dict[str, tuple[int, int]] = {
    "sim1": (2, 3),
    "sim2": (4, 5),
    "exp1_1": (7, 8),
    "exp1_2": (9, 10),
    "exp2": (11, 12),
}

REFERENCE = (
    "Chai, Liang, Yang, Han (2022), Energy-based nonlinear adaptive control for collaborative "
    "transportation systems, Aerospace Science and Technology 126, 107510"
)

# By metric: label, decimals, whether less is better (None: neither), whether a headline.
_METRICS: dict[str, tuple[str, int, bool | None, bool]] = {
    "peak_swing_1": ("Peak swing, cable 1", 2, True, True),
    "peak_swing_2": ("Peak swing, cable 2", 2, True, False),
    "peak_swing_3": ("Peak deflection of the bar", 2, True, False),
    "swing_settling_time": ("Swing settled", 1, True, True),
    "position_settling_time": ("Position settled", 1, True, True),
    "combined_settling": ("All of these settled", 1, True, True),
    "rest_settling_time": ("Load at rest", 1, True, False),
    "overshoot": ("Overshoot", 3, True, True),
    "swing_integral": ("Integral of swing", 1, True, False),
    "control_effort": ("Control effort", 1, True, False),
    "peak_thrust": ("Peak thrust", 2, None, False),
    "peak_tilt": ("Peak tilt", 1, None, False),
    "min_tension": ("Least tension", 2, None, False),
    "storage_rise": ("Greatest rise of storage", 4, None, False),
}

_AUDIT_LABELS = {
    "storage_start": "Storage function at the start",
    "storage_end": "Storage function at the end",
    "dissipation": "Dissipation, right side of (57)",
    "internal_force": "Internal force, the term (57) lacks",
    "push": "Pushes",
    "actuation": "Actuation: force applied less the law's",
    "adaptation": "Adaptation held between instants",
    "integration_error": "Integration error: what is left over",
    "largest_integration_error": "Its greatest size during the run",
}


def figure_stem(number: int, name: str, kind: str) -> str:
    """File name, less its ending, of a figure: "fig02_sim1_response"."""
    return f"fig{number:02d}_{name}_{kind}"


def assumptions(scenario: PlanarScenario) -> list[str]:
    """What the paper does not give for a test and this scenario chose, with its values."""
    plant, law, sim = scenario.plant, scenario.controller, scenario.simulation
    drag, swing = _span(plant.vehicle_drag), _span(plant.swing_damping)
    result = [
        f"Damping (14): vehicles {drag} N s/m, angles {swing} N m s. The paper names it but gives "
        "no numbers.",
        f"The drag estimates start at {_span(law.d_hat_start)} N s/m; the run lasts "
        f"{sim.duration:g} s.",
    ]
    if not scenario.is_ideal():
        act, sens = scenario.actuators, scenario.sensors
        result.append(
            f"The testbed: law at {law.rate:g} Hz; command delay "
            f"{1e3 * act.command_delay:g} ms; first-order lag of thrust "
            f"{1e3 * act.thrust_time_constant:g} ms and attitude "
            f"{1e3 * act.attitude_time_constant:g} ms; thrust up to {act.thrust_max:g} N, tilt up "
            f"to {math.degrees(act.tilt_max):.0f}°; motion capture every "
            f"{1e3 * (sens.period or 1 / law.rate):g} ms, {1e3 * sens.delay:g} ms late, noise "
            f"{1e3 * sens.position_noise:g} mm, {sens.velocity_noise:g} m/s, "
            f"{math.degrees(sens.angle_noise):.2g}°, "
            f"{math.degrees(sens.angle_rate_noise):.2g}°/s; seed {sim.seed}."
        )
    for push in scenario.values["push"][:1]:
        result.append(
            f"Each push: {push['force'][0]:g} N along y at its peak, {push['duration']:g} s long, "
            f"a {push['shape'].replace('_', ' ')}. The paper does not size them."
        )
    return result


def build(
    runs: claims.Runs,
    figures: Path,
    tables: Sequence[report.Sensitivity],
    beside: Sequence[str],
) -> report.Page:
    """The page for runs by scenario, then controller.

    Args:
        runs: finished or not; each scenario under the same laws.
        figures: folder that holds the figures' PNG files.
        tables: of varied assumptions and of studies.
        beside: further laws as given on the command line, for the commands shown.
    """
    found = claims.check_claims(runs)
    options = "".join(f" --with {law}" for law in beside)
    return report.Page(
        title="Two vehicles, one bar: the paper, run again",
        subtitle="Energy-coupled adaptive control against PD, in five tests",
        reference=REFERENCE,
        summary=_summary(runs, found),
        tests=[_test(runs[name], figures) for name in runs],
        metrics=_metric_infos(),
        claims=found,
        discrepancies=claims.discrepancies(),
        sensitivity=tables,
        audit=[
            report.MetricInfo(
                name=name,
                label=_AUDIT_LABELS.get(name, name),
                unit=q.unit,
                doc=q.doc,
                digits=4,
                lower_is_better=None,
            )
            for name, q in quantities.AUDIT.items()
        ],
        commands=[
            report.Command(
                what="Everything on this page",
                line=f"multilift reproduce -o out/paper{options}",
            ),
            report.Command(
                what="Your own law beside the paper's",
                line="multilift reproduce -o out/mine --with my_law.py:MyLaw",
            ),
        ],
        provenance=[*provenance.describe().items()],
        files=[
            report.FileInfo(path="metrics.json", what="metrics, audit and ending of every run"),
            report.FileInfo(path="run.json", what="versions, platform, seeds"),
            report.FileInfo(path="figures", what="every figure as PNG and PDF"),
            *(
                report.FileInfo(
                    path=name,
                    what="trajectories as Parquet, one file a law, and the effective scenarios",
                )
                for name in runs
            ),
        ],
    )


def _summary(runs: claims.Runs, found: Sequence[report.Claim]) -> list[str]:
    sim1 = runs["sim1"]
    peak = {law: sim1[law].metrics["peak_swing_1"] for law in LAW_LABELS}
    swing = {law: sim1[law].metrics["swing_settling_time"] for law in LAW_LABELS}
    place = {law: sim1[law].metrics["position_settling_time"] for law in LAW_LABELS}
    held = sum(claim.verdict == "holds" for claim in found)
    worst = max(run.closure_residual for laws in runs.values() for run in laws.values())
    energy = max(
        run.audit["largest_integration_error"] for laws in runs.values() for run in laws.values()
    )
    return [
        f"The paper's main claim, less swing and sooner quiet, {found[0].verdict}: in Sim 1 the "
        f"load swings {peak['energy_coupled']:.1f}° at most, {peak['pd']:.1f}° under PD, and is "
        f"quiet after {claims.seconds(swing['energy_coupled'])}, {claims.seconds(swing['pd'])} "
        "under PD.",
        f"Its claim of equal positioning {found[2].verdict}: there the vehicles are within 2 cm of "
        f"their goals for good after {claims.seconds(place['energy_coupled'])}, "
        f"{claims.seconds(place['pd'])} under PD.",
        f"Of {len(found)} claims {held} hold in full; each is listed below with its numbers.",
        f"Every run checks itself: the bar's geometry is kept to {worst:.0e} m and the energy "
        f"balance closes to {energy:.0e} J.",
    ]


def _metric_infos() -> list[report.MetricInfo]:
    return [
        report.MetricInfo(
            name=name,
            label=_METRICS[name][0],
            unit=q.unit,
            doc=q.doc,
            digits=_METRICS[name][1],
            lower_is_better=_METRICS[name][2],
            headline=_METRICS[name][3],
            missing="still outside its band when the run ended",
        )
        for name, q in quantities.METRICS.items()
    ]


def _test(laws: Mapping[str, PlanarRun], figures: Path) -> report.PaperTest:
    scenario = laws["energy_coupled"].scenario
    name, (response, command) = scenario.name, FIGURES[scenario.name]
    plant = scenario.plant
    short = scenario.title.split(":")[0]
    ordered = sorted(laws.values(), key=lambda run: run.controller != "pd")
    both = "all laws" if len(laws) > 2 else "both laws"
    return report.PaperTest(
        key=name,
        title=scenario.title,
        short=short,
        source=str(scenario.values["source"]).rsplit("(2022), ", 1)[-1],
        description=[str(scenario.values["description"])],
        geometry=report.Geometry(
            l0=plant.bar_length,
            l1=plant.cable_length[0],
            l2=plant.cable_length[1],
            l3=plant.bar_half_thickness,
        ),
        start=scenario.q_start[:4].tolist(),
        goal=scenario.goal_vector().tolist(),
        runs=[_run_view(run) for run in ordered],
        pushes=[
            report.Push(
                body=push["body"],
                force=(push["force"][0], push["force"][1]),
                start=push["start"],
                duration=push["duration"],
                shape=push["shape"],
                frequency=push["frequency"] or 0.0,
            )
            for push in scenario.values["push"]
        ],
        figures=[
            report.Figure(
                number=f"Fig. {number}",
                caption=f"{short}: {what} under {both}; the counterpart of the paper's "
                f"Fig. {number}.",
                alt=f"{what} over time for {short}, one curve for each law",
                png=(figures / f"{figure_stem(number, name, kind)}.png").read_bytes(),
            )
            for number, kind, what in (
                (response, "response", "positions, angles and drag estimates"),
                (command, "commands", "commands u1 to u4"),
            )
        ],
        command=f"multilift run {name} -o out/{name}",
        assumptions=assumptions(scenario),
    )


def _run_view(run: PlanarRun) -> report.RunView:
    series = {column: run[column] for column in run.columns}
    applied = run.thrust_attitude()
    for k in (1, 2):
        series[f"thrust{k}"] = applied[f"thrust{k}_applied"]
        series[f"attitude{k}"] = applied[f"attitude{k}_applied"]
    return report.RunView(
        law=run.controller,
        title=LAW_LABELS.get(run.controller, run.controller_title),
        status=run.status,
        status_sentence=run.ending,
        series=series,
        metrics=run.metrics,
        audit=run.audit,
    )


def _span(values: object) -> str:
    array = np.ravel(np.asarray(values, dtype=float))
    lo, hi = float(array.min()), float(array.max())
    return f"{lo:g}" if lo == hi else f"{lo:g} to {hi:g}"
