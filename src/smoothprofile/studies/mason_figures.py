"""The figure of the study of Mason numbers, drawn from its curve alone."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.figures import LEVEL, PALETTE, Picture, drawing, new_panels, power_of_ten

LABELS = {"wall": "on the electrodes", "viscous": "viscous", "contact": "contact",
          "electric": "electric"}  # fmt: skip


def pictures(curves: Mapping[str, Mapping[str, np.ndarray]]) -> list[Picture]:
    """The viscosity above that without a field, and what bears the stress, against Mn."""
    curve = curves["viscosity"]
    order = np.argsort(curve["Mn"])
    number = curve["Mn"][order]
    with drawing():
        figure, (left, right) = new_panels(2, height=3.7, width=9.4)
        free = curve["wall"][order[-1]]
        excess = curve["wall"][order[:-1]] - free
        left.errorbar(
            number[:-1],
            excess,
            curve["wall_error"][order[:-1]],
            fmt="o-",
            capsize=3,
            label="μ_app − μ_free",
        )
        left.set(xscale="log", yscale="log")
        left.loglog(number[:-1], excess[0] * number[0] / number[:-1], **LEVEL, label="slope −1")
        for (name, label), colour in zip(LABELS.items(), PALETTE[3::-1], strict=True):
            right.semilogx(number, curve[name][order], "o-", color=colour, label=label)
        right.axhline(1.0, **LEVEL)
        for axes in (left, right):
            axes.xaxis.set_major_formatter(power_of_ten)
            axes.legend()
            axes.set_xlabel("Mn = μγ̇/(2εβ²E²)")
        left.yaxis.set_major_formatter(power_of_ten)
        left.set(title="Viscosity that the field adds", ylabel="(μ_app − μ_free)/μ (–)")
        right.set(title="What bears the stress", ylabel="stress/(μγ̇) (–)")
    caption = (
        "Apparent viscosity above that of the same beads with hardly a field, and the parts of the "
        "stress on the electrodes, against the Mason number."
    )
    return [Picture("mason", caption, figure, wide=True)]
