# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Net power: a manoeuvre, a whole orbit of tasks, and magnetorquers in free time
#
# B. A. Kristiansen, *Energy and time optimal spacecraft attitude control and operations* (doctoral
# thesis, 2023), chapters 4 to 6, turns satellites so that the panels give as much, and the
# actuators take as little, as can be. This notebook solves the three cases from a few random starts
# each, flies every answer again with fine steps, exact panels and the exact shadow, and draws the
# source's figures. All numbers below are those of the flights.

# %%
import numpy as np
from IPython.display import Markdown, display

import jaxatt
from jaxatt import compare, scenarios
from jaxatt.attitude.components import Matrix, Quaternion, Vector
from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.drawing.panels import limits, lines, references, runs
from jaxatt.environment.eclipse_times import eclipses
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.answers import phase_manoeuvre
from jaxatt.problems.net_power.baseline import fly_baseline
from jaxatt.problems.net_power.build import options_of
from jaxatt.problems.net_power.record import net_power
from jaxatt.problems.net_power.report.plan_figures import figures as plan_figures
from jaxatt.problems.net_power.satellite_surroundings import sunlight_at, surroundings_at
from jaxatt.problems.net_power.sun_attitude import sun_attitude
from jaxatt.records.timeline import timeline

jaxatt.configure()

STARTS = {"hypso1-netpower": 8, "hypso2-orbit": 2, "mtq-free-time": 2}
# The bundled scenarios ask for 64; a few keep this notebook short.
QUATERNION = [r"$\eta$", *(rf"$\epsilon_{k}$" for k in (1, 2, 3))]
RATE = [rf"$\omega_{axis}$" for axis in "xyz"]
RPM = 60.0 / (2.0 * np.pi)


def say(text):
    """Show a sentence with numbers of this run."""
    display(Markdown(text))


def panels(title, labels, height=1.9):
    """Empty panels above each other, with these labels."""
    figure = picture(9.0, height * len(labels) + 0.9, title)
    column = figure.subplots(len(labels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, label in zip(column, labels, strict=True):
        axes.set_ylabel(label)
        tidy(axes)
    column[-1].set_xlabel("time [s]")
    return figure, column


def legend(axes):
    """Legend beside the axes."""
    axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))


def steady(q):
    """Quaternions (n, 4) without jumps of their sign."""
    jumps = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0.0, -1.0, 1.0)
    return q * np.concatenate([[1.0], np.cumprod(jumps)])[:, None]


# %% [markdown]
# ## Chapter 4: half a turn in 40 s
#
# Printed values stand beside. The PD law holds the sun attitude and turns back 20 s before the
# end.

# %%
turn = compare("hypso1-netpower", starts=STARTS["hypso1-netpower"])
display(turn)

# %%
best = turn.results["optimum"].phases[0]
options = options_of(turn.scenario)
manoeuvre = phase_manoeuvre(turn.scenario, PhaseStart())
flown = fly_baseline([manoeuvre], options.baseline)
time, edges = np.linspace(0.0, manoeuvre.duration, 81), np.linspace(0.0, manoeuvre.duration, 81)
law = {
    "q_ib": flown.q_ib[0],
    "omega_ib": flown.omega_ib[0],
    "torque_body": flown.wheel_torque[0] @ np.asarray(manoeuvre.satellite.craft.wheels.axes).T,
    "solar_power": flown.solar_power[0],
    "actuation_power": flown.wheel_power[0],
    "net_power": flown.solar_power[0] - flown.wheel_power[0],
    "net_energy": np.concatenate([[0.0], np.cumsum(flown.energy.net[0])]),
}
ways = {"optimum": best.series, "PD law": law}
sun, _ = sunlight_at(manoeuvre.satellite, np.zeros(1))
toward = sun_attitude(
    manoeuvre.satellite.craft.panels,
    float(manoeuvre.satellite.light.irradiance),
    sun[0],
    manoeuvre.start.q_ib,
)
back = manoeuvre.duration - options.baseline.turn_back

figure, column = panels(
    "As figures 4.1 and 4.2: attitude, dotted what the PD law turns to", list(ways), 2.4
)
for axes, (name, series) in zip(column, ways.items(), strict=True):
    q = steady(series["q_ib"])
    lines(axes, time, q, QUATERNION)
    end = manoeuvre.end.q_ib
    references(axes, back, manoeuvre.duration, end if end @ q[-1] >= 0.0 else -end)
    if name == "PD law":
        references(axes, 0.0, back, toward if toward @ q[len(q) // 4] >= 0.0 else -toward)
    axes.set_ylabel(f"quaternion\n{name}")
    legend(axes)
display(figure)

# %%
figure, column = panels("As figure 4.3: rates", [f"{name}\n[deg/s]" for name in ways])
for axes, series in zip(column, ways.values(), strict=True):
    lines(axes, time, np.degrees(series["omega_ib"]), RATE)
    legend(axes)
display(figure)

# %%
figure, column = panels("As figure 4.4: torques", [f"{name}\n[mN m]" for name in ways])
most = 1e3 * np.asarray(manoeuvre.satellite.craft.wheels.torque_limit)
for axes, series in zip(column, ways.values(), strict=True):
    for k, axis in enumerate("xyz"):
        torque = 1e3 * series["torque_body"][:, k]
        axes.stairs(torque, edges, baseline=None, color=colour(k), label=rf"$\tau_{axis}$")
    limits(axes, np.unique(most))
    legend(axes)
display(figure)

# %% [markdown]
# Between two nodes the wheels' power follows their speed; at a node, where the torque jumps, the
# power after it is drawn.

# %%
figure, column = panels(
    "As figures 4.5 to 4.7: power", ["net [W]", "solar [W]", "actuation [W]"], 1.8
)
for axes, name in zip(column, ("net_power", "solar_power", "actuation_power"), strict=True):
    for k, (way, series) in enumerate(ways.items()):
        axes.plot(time, series[name], color=colour(k), linewidth=1.4, label=way)
legend(column[0])
display(figure)

# %%
figure, (above, below) = panels(
    "As figures 4.8 and 4.9: net energy, and gain over the PD law", ["net energy [J]", "gain [%]"]
)
for k, (way, series) in enumerate(ways.items()):
    above.plot(time, series["net_energy"], color=colour(k), linewidth=1.4, label=way)
gained = best.series["net_energy"] - law["net_energy"]
below.plot(time[1:], 100.0 * gained[1:] / law["net_energy"][1:], color=colour(0), linewidth=1.4)
legend(above)
display(figure)
early = float(np.interp(back, time, gained))
say(
    f"Of the {gained[-1]:.1f} J that the optimum earns more, {early:.1f} J are earned while the PD "
    f"law still holds the sun ({back:g} s), the other {gained[-1] - early:.1f} J after it has let "
    f"go. Solar power reaches {best.series['solar_power'].max():.1f} W, the magnitude of actuation "
    f"power {np.abs(best.series['actuation_power']).max():.2f} W: net power looks like solar power."
)

# %% [markdown]
# ## Chapter 5: twenty tasks in one orbit
#
# HYPSO-2 harvests, images and communicates. Every task begins at the flown end of the one before.
# Here the tasks are solved in sequence; `jaxatt plan hypso2-orbit` then improves them together.

# %%
sequence = scenarios.replace(scenarios.load("hypso2-orbit"), {"plan.joint": False})
orbit = compare(sequence, starts=STARTS["hypso2-orbit"])
display(orbit)

# %%
plan = orbit.results["optimum"]
line = timeline(plan.phases)
craft = plan.scenario.vehicle
ahead = [phase for phase in plan.phases if net_power(phase).mode == "harvest"]


def over_the_orbit(title, labels, height=1.9):
    """Panels with the eclipse shaded and a line at the start of each harvest."""
    figure, column = panels(title, labels, height)
    for axes in column:
        for first, last in runs(line.nodes["light"] < 1.0):
            stop = line.time[min(last, len(line.time) - 1)]
            axes.axvspan(line.time[first], stop, color="#D9D9D9", linewidth=0, zorder=0)
        for phase in ahead:
            axes.axvline(phase.start_time, color="#777777", linewidth=0.6, zorder=0.5)
    column[-1].set_xlim(line.time[0], line.time[-1])
    return figure, column


figure, (axes,) = over_the_orbit("As figure 5.6: attitude", ["quaternion"], 3.0)
lines(axes, line.time, steady(line.nodes["q_ib"]), QUATERNION)
legend(axes)
display(figure)

# %%
figure, column = over_the_orbit(
    "As figures 5.7 to 5.10: net power, light, solar and actuation power",
    ["net [W]", "light", "solar [W]", "actuation [W]"],
    1.6,
)
for axes, name in zip(
    column, ("net_power", "light", "solar_power", "actuation_power"), strict=True
):
    axes.plot(line.time, line.nodes[name], color=colour(0), linewidth=1.1)
display(figure)
dark = line.nodes["light"] <= 0.0
spent = line.nodes["actuation_power"][dark]
fast = np.degrees(np.linalg.norm(line.nodes["omega_ib"], axis=1))[dark].max()
say(
    f"In the umbra the actuators take {spent.mean():.2f} W on the mean, {spent.max():.2f} W at "
    f"most; in the light {line.nodes['actuation_power'][~dark].mean():.2f} W on the mean. "
    f"There the satellite turns at up to {fast:.1f} deg/s all the same: motion that costs next to "
    "nothing and earns nothing, which the solver leaves as it is."
)

# %%
figure, (axes,) = over_the_orbit("As figure 5.11: energy since the start", ["energy [kJ]"], 3.6)
width = np.diff(line.time)
for k, name in enumerate(("net_energy", "solar_power", "actuation_power")):
    if name == "net_energy":
        continue
    mean = 0.5 * (line.nodes[name][1:] + line.nodes[name][:-1])
    total = np.concatenate([[0.0], np.cumsum(mean * width)])
    axes.plot(line.time, 1e-3 * total, color=colour(k), linewidth=1.1, label=name.split("_")[0])
before = {"net": 0.0, "PD law": 0.0}
drawn = {name: ([], []) for name in before}
for phase in plan.phases:
    for name, series in (("net", phase.series), ("PD law", net_power(phase).baseline)):
        drawn[name][0].append(phase.start_time + phase.step * np.arange(len(series["net_energy"])))
        drawn[name][1].append(before[name] + series["net_energy"])
        before[name] += series["net_energy"][-1]
for (name, (times, values)), style in zip(drawn.items(), ("solid", "dashed"), strict=True):
    axes.plot(
        np.concatenate(times),
        1e-3 * np.concatenate(values),
        color=colour(0 if name == "net" else 3),
        linestyle=style,
        linewidth=1.6,
        label=name,
    )
legend(axes)
display(figure)

# %%
figure, column = over_the_orbit(
    "As figures 5.12 to 5.14: rates, wheel torques and speeds",
    ["rates [deg/s]", "torques [mN m]", "speeds [rpm]"],
    2.2,
)
lines(column[0], line.time, np.degrees(line.nodes["omega_ib"]), RATE)
names = [f"wheel {k + 1}" for k in range(craft.wheels.count)]
for k, name in enumerate(names):
    torque = 1e3 * line.intervals["torque_wheels"][:, k]
    column[1].stairs(torque, line.edges, baseline=None, color=colour(k), label=name)
lines(column[2], line.time, RPM * line.nodes["omega_bw"], names)
for axes in column:
    legend(axes)
display(figure)

# %%
satellite = options_of(plan.scenario).satellite
along = surroundings_at(satellite, line.time)
turned, omega = Quaternion.of(line.nodes["q_ib"]), Vector.of(line.nodes["omega_ib"])
inertia = Matrix.of(satellite.craft.inertia)
parts = (turned, omega, along, inertia)
disturbing = np.asarray(satellite.torques.total(*parts, None).array)
both = np.asarray(satellite.torques.total(*parts, Vector.of(line.nodes["dipole"])).array)
magnetic = both - disturbing
figure, column = over_the_orbit(
    "As figures 5.15 and 5.16: torques of the magnetorquers, disturbing torques",
    ["dipole [A m$^2$]", "magnetorquers\n[µN m]", "disturbing\n[µN m]"],
)
lines(column[0], line.time, line.nodes["dipole"], [rf"$m_{axis}$" for axis in "xyz"])
for axes, torque in zip(column[1:], (magnetic, disturbing), strict=True):
    lines(axes, line.time, 1e6 * torque, [rf"$\tau_{axis}$" for axis in "xyz"])
for axes in column:
    legend(axes)
display(figure)
display(plan_figures(plan)["ground_track"]())

# %% [markdown]
# ## Chapter 6: magnetorquers alone, in free time
#
# The final time is found with the rest. The cost (6.2a) is what attitude and rate are off at the
# end, plus k3 times the final time, less the mean net power. All nine weights k3 of table 6.4 are
# solved in one batch.

# %%
weighed = compare("mtq-free-time", starts=STARTS["mtq-free-time"])
display(weighed)
display(Markdown("*As figure 6.6:*"))
display(weighed.plot())

# %%
slow, ours, theirs = weighed.phases[0], weighed.rows[0], weighed.printed[0]
last = slow.final_time
stay = np.linspace(0.0, last, len(slow.series["light"]))
cubesat = options_of(weighed.scenario).satellite
orbiting = np.linspace(0.0, theirs.final_time_s, 2000)
_, light = sunlight_at(cubesat, orbiting)
(shadow,) = eclipses(cubesat.orbit, cubesat.light, 0.0, theirs.final_time_s)


def in_free_time(title, labels, until, height=2.2):
    """Panels with the eclipse shaded."""
    figure, column = panels(title, labels, height)
    for axes in column:
        axes.axvspan(
            shadow.penumbra_entry, shadow.penumbra_exit, color="#D9D9D9", linewidth=0, zorder=0
        )
        axes.set_xlim(0.0, until)
    return figure, column


figure, column = in_free_time(
    f"As figures 6.1 to 6.3, k3 = {weighed.rows[0].time_weight:g} W/s",
    ["quaternion $q_{ob}$", "rate $\\omega_{ob}$ [deg/s]", "dipole [A m$^2$]"],
    last,
)
q = steady(slow.series["q_ob"])
lines(column[0], stay, q, QUATERNION)
wanted = weighed.scenario.targets[0].q_ob
references(column[0], 0.0, last, wanted if wanted @ q[-1] >= 0.0 else -wanted)
lines(column[1], stay, np.degrees(slow.series["omega_ob"]), RATE)
for k, axis in enumerate("xyz"):
    dipole = slow.controls[:, k]
    column[2].stairs(dipole, stay, baseline=None, color=colour(k), label=rf"$m_{axis}$")
most_dipole = np.asarray(weighed.scenario.vehicle.magnetorquers.dipole_limit)
limits(column[2], np.unique(most_dipole))
for axes in column:
    legend(axes)
display(figure)

# %%
figure, column = in_free_time(
    f"As figures 6.4 and 6.5, as long as the printed manoeuvre, {theirs.final_time_s:.0f} s",
    ["net power [W]", "light"],
    theirs.final_time_s,
    1.8,
)
column[0].plot(stay, slow.series["net_power"], color=colour(0), linewidth=1.4)
column[1].plot(orbiting, light, color=colour(0), linewidth=1.4)
display(figure)
saturated = float((np.abs(slow.controls) > 0.999 * most_dipole).any(axis=1).mean())
say(
    f"With k3 = {ours.time_weight:g} W/s the manoeuvre takes {last:.0f} s; the Earth's shadow lies "
    f"between {shadow.penumbra_entry:.0f} and {shadow.penumbra_exit:.0f} s. Mean net power is "
    f"{ours.mean_power_W:.2f} W, and a dipole is at its limit in {100.0 * saturated:.0f} % of the "
    f"intervals. The printed manoeuvre takes {theirs.final_time_s:.0f} s, through the shadow: "
    f"{theirs.mean_power_W:.2f} W are left."
)
