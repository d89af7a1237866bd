"""[contact] of a case: how bodies and walls push each other when they come near."""

from typing import Annotated

from pydantic import Field

from smoothprofile.config.values import FLAG, POSITIVE, Positive, Table


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
