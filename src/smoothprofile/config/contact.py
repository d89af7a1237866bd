"""[contact] of a case: how bodies and walls push each other when they come near."""

from typing import Annotated

from pydantic import Field

from smoothprofile.config.domain import Domain
from smoothprofile.config.refusals import Refusal
from smoothprofile.config.values import AXES, FLAG, POSITIVE, Positive, Table


class Contact(Table):
    """[contact]: a soft repulsion within `range` of gap, one cell if left out.

    restitution: speed after a dry impact over speed before. friction: Coulomb's coefficient.
    lubrication: adds what the grid does not resolve of the lubrication force between spheres,
    and between spheres and walls, within the same range.
    """

    range: Positive | None = Field(None, description=POSITIVE)
    restitution: Annotated[float, Field(ge=0.01, le=1)] = Field(
        0.5, description="a number from 0.01 to 1"
    )
    friction: Annotated[float, Field(ge=0)] = Field(0.0, description="a finite number, 0 or more")
    lubrication: bool = Field(False, description=FLAG)

    def check(self, domain: Domain) -> None:
        """Refusal of a range that reaches farther than half of the box."""
        axis = min(range(3), key=lambda d: domain.lengths[d])
        most = 0.5 * domain.lengths[axis]
        if self.range is None or self.range <= most:
            return
        if domain.periodic[axis]:
            why = f"half the period along {AXES[axis]}, for a pair meets in its nearest image alone"
        else:
            why = f"half the room between the ends of {AXES[axis]}, for both would push at once"
        raise Refusal("contact.range", self.range, f"it must be at most {most:g}, {why}")
