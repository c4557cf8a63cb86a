#!/usr/bin/env python3
"""Draws bench/results/curves.json of bench_curves: a figure for each scene and seed.

    bench/plot_curves.py bench/results/curves.json FOLDER [VARIANT …]

Mean error, completeness and coverage over the number of photos, a line a session; without
variants all of them. Needs Debian's python3-matplotlib.
"""
import collections
import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend has to be chosen first)

# Okabe and Ito's colours, which colour-blind people tell apart; then the same, dashed.
COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]


def percent(values):
    return [None if value is None else 100 * value for value in values]


def panels(iterations):
    """Title and values of every panel, for one session."""
    yield "mean error, mm", [
        None if i.get("mean_error_m") is None else 1000 * i["mean_error_m"] for i in iterations
    ]
    for key in iterations[0].get("completeness", {}):
        yield f"truth within {key}, %", percent([i["completeness"].get(key) for i in iterations])
    yield "covered, %", percent([i.get("covered_ratio") for i in iterations])


def draw(title, sessions, path):
    titles = [name for name, _ in panels(sessions[0]["summary"]["iterations"])]
    figure, axes = plt.subplots(1, len(titles), figsize=(4.4 * len(titles), 3.8), squeeze=False)
    for number, session in enumerate(sessions):
        iterations = session["summary"]["iterations"]
        photos = [i["photos"] for i in iterations]
        for axis, (_, values) in zip(axes[0], panels(iterations)):
            axis.plot(photos, values, marker="o", markersize=3, linewidth=1.6,
                      color=COLORS[number % len(COLORS)],
                      linestyle="-" if number < len(COLORS) else "--", label=session["variant"])
    for axis, name in zip(axes[0], titles):
        axis.set_title(name, fontsize=11)
        axis.set_xlabel("photos")
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.suptitle(title)
    figure.legend(handles, labels, loc="lower center", ncol=min(6, len(labels)), frameon=False)
    rows = -(-len(labels) // 6)
    figure.tight_layout(rect=(0, 0.03 + 0.05 * rows, 1, 1))
    figure.savefig(path, dpi=110)
    plt.close(figure)
    print(path)


def main(arguments):
    if len(arguments) < 2:
        sys.exit(__doc__)
    curves = json.loads(pathlib.Path(arguments[0]).read_text())
    folder = pathlib.Path(arguments[1])
    folder.mkdir(parents=True, exist_ok=True)
    wanted = arguments[2:]
    groups = collections.defaultdict(list)
    for curve in curves:
        if not wanted or curve["variant"] in wanted:
            groups[curve["scene"], curve["seed"]].append(curve)
    if not groups:
        sys.exit(f"{arguments[0]}: no session of {', '.join(wanted) or 'any name'}")
    for (scene, seed), sessions in groups.items():
        draw(f"{scene}: the fast model after every iteration", sessions,
             folder / f"curves_{scene}_{seed}.png")


if __name__ == "__main__":
    main(sys.argv[1:])
