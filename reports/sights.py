"""What observers see: their luminance pictures, on one scale, and the figures read off them."""

from __future__ import annotations

from collections.abc import Sequence

from lelight.reports.figures.scales import LogScale, luminance_scale
from lelight.reports.folder import ResultFolder
from lelight.reports.pictures import LuminancePicture, read_picture
from lelight.reports.rounding import significant, with_unit


def read_pictures(folder: ResultFolder) -> list[LuminancePicture]:
    """Read every observer's picture, in the order of ``metrics.json``."""
    return [
        read_picture(
            folder.file(
                "observers",
                f"{observer.stem}.exr",
                remedy=f"`lelight render {folder.path} --observer '{observer.name}'` writes it",
            )
        )
        for observer in folder.observers
    ]


def common_scale(pictures: Sequence[LuminancePicture]) -> LogScale:
    """One scale of luminance over all pictures of a report, so that colours can be compared."""
    return luminance_scale([picture.luminance[picture.disc] for picture in pictures])


def picture_statistics(picture: LuminancePicture) -> list[tuple[str, str]]:
    """Luminances of a view by solid angle: mean, median, the brightest 5 %, extremes."""
    brightest, darkest = (picture.luminance[picture.extremum(largest)] for largest in (True, False))
    luminances = [
        ("Mean over the view", picture.mean),
        ("Median", picture.quantile(0.5)),
        ("Exceeded in 5 % of the view", picture.quantile(0.95)),
        ("Largest (▲ max)", float(brightest)),
        ("Smallest (▼ min)", float(darkest)),
    ]
    return [(name, with_unit(significant(luminance), "cd/m²")) for name, luminance in luminances]
