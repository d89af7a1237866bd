"""The ways a run ends before its end, as exceptions that carry a sentence for the user."""


class CaseError(ValueError):
    """Input that cannot be run. Exit code 2.

    One sentence: which key, what it was, what is allowed.
    """


class BlowUpError(ArithmeticError):
    """A run that stopped being a solution: NaN, infinity or divergence. Exit code 3.

    Names the field, the cell, the time and the limit that was exceeded. `step` is a Δt that would
    have held; None if Δt has no part in it.
    """

    def __init__(self, message: str, step: float | None = None):
        super().__init__(message)
        self.step = step


class StoppedError(Exception):
    """A run that was asked to stop, or whose time was up, after a checkpoint. Exit code 4."""


class OutputError(Exception):
    """A file of a run that cannot be written. Exit code 2.

    Names the file and what the system says is wrong.
    """
