"""Plots what crust_limits printed: crust_limits_plot.py <figures.txt> <plot.png>"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

TITLES = {"sheet": "sheet, thickness", "gap": "two balls, distance", "torus": "torus, tube diameter",
          "rings": "the same in rings", "hole": "plate with holes, diameter", "fins": "fins, walls and gaps"}
rows = [line.split() for line in open(sys.argv[1]) if line.strip()]
figure, axes = plt.subplots(1, len(TITLES), figsize=(15.6, 2.6), sharey=True)
for axis, (name, title) in zip(axes, TITLES.items()):
    mine = [(float(n), float(t), int(r) / int(k)) for shape, n, t, r, k in rows if shape == name]
    noises = sorted({n for n, _, _ in mine})
    widths = sorted({t for _, t, _ in mine})
    share = [[next((s for n2, t2, s in mine if (n2, t2) == (n, t)), float("nan")) for t in widths] for n in noises]
    axis.imshow(share, origin="lower", aspect="auto", cmap="RdYlGn", vmin=0, vmax=1)
    axis.set_xticks(range(len(widths)), [f"{t:g}" for t in widths], fontsize=7)
    axis.set_yticks(range(len(noises)), [f"{n:g}" for n in noises], fontsize=7)
    axis.set_xlabel("spacings", fontsize=8)
    axis.set_title(title, fontsize=9)
axes[0].set_ylabel("noise [spacings]", fontsize=8)
figure.tight_layout()
figure.savefig(sys.argv[2], dpi=75)
