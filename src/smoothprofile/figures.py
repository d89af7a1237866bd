"""How every figure looks: its style, and a figure as a picture with its caption."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imsave

from smoothprofile.labels import in_units

DASHES = ("-", "--", ":")
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
LEVEL = {"color": "black", "linestyle": (0, (6, 3)), "linewidth": 1.0}
EXACT = {"color": "black", "linestyle": "--", "linewidth": 1.0}
GUIDE = {"color": "#888888", "linestyle": ":", "linewidth": 1.2}

# Okabe and Ito: told apart with every kind of colour blindness.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

STYLE = {
    "figure.dpi": 150,
    "figure.constrained_layout.w_pad": 0.08,
    "figure.constrained_layout.h_pad": 0.06,
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.prop_cycle": matplotlib.cycler(color=PALETTE),
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "lines.linewidth": 1.5,
    "lines.markersize": 5,
    "legend.frameon": False,
    "image.cmap": "viridis",
}

WIDTH = 5.4


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure, the name of its file, the sentence below it, and whether it takes a whole row."""

    name: str
    caption: str
    figure: Figure
    wide: bool = False

    @cached_property
    def png(self) -> bytes:
        """The figure as a PNG image, of as many dots to the inch as the style says."""
        buffer = BytesIO()
        with drawing():
            # Figure.savefig would draw everything twice.
            self.figure.canvas.draw()
            imsave(buffer, self.figure.canvas.buffer_rgba(), format="png", dpi=self.figure.dpi)
        return buffer.getvalue()


def drawing():
    """The context in which figures are made: `with drawing(): …`."""
    return matplotlib.rc_context(STYLE)


def new_figure(height: float, width: float = WIDTH) -> tuple[Figure, Axes]:
    """An empty figure of one panel, in inches."""
    figure, (axes,) = new_panels(1, height, width)
    return figure, axes


def new_panels(count: int, height: float, width: float) -> tuple[Figure, list[Axes]]:
    """An empty figure of some panels side by side, in inches."""
    figure = Figure(figsize=(width, height), layout="compressed")
    FigureCanvasAgg(figure)
    return figure, list(figure.subplots(1, count, squeeze=False)[0])


def name_units(figure: Figure, units: Mapping[str, str]) -> None:
    """Put the units of a case, `length` and `time` of its [units], into the axes of a figure."""
    for axes in figure.axes:
        axes.set_xlabel(in_units(axes.get_xlabel(), units))
        axes.set_ylabel(in_units(axes.get_ylabel(), units))


def legend_below(axes: Axes, columns: int) -> None:
    """One legend under all panels of the figure, of what one of them names."""
    handles, labels = axes.get_legend_handles_labels()
    axes.figure.legend(handles, labels, loc="outside lower center", ncols=columns)


def power_of_ten(value: float, _: int) -> str:
    """10⁻³ for 0.001, without setting a formula."""
    return "10" + f"{round(np.log10(value))}".translate(SUPERSCRIPTS) if value > 0 else ""
