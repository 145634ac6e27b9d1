"""Measured dimensions of the specimens, inline or in a file of their own."""

from collections.abc import Mapping

from shakerproc.documents import Document, Key, read_document
from shakerproc.testlog.equipment import Specimen
from shakerproc.testlog.paths import Below, relative_path
from shakerproc.testlog.schema import LogSection, SpecimenSection, SpecimensFile

Table = Mapping[tuple[str, str], Specimen]


def specimens_of(document: Document[LogSection]) -> Table:
    """Return the specimens of a log by joint and name.

    Raises
    ------
    DocumentError
        If dimensions contradict each other, or the file of specimens cannot be used.
    """
    entry = document.value.specimens
    if not isinstance(entry, str):
        return _table(document, entry, ("specimens",))
    try:
        path = Below(document.path.parent).path(entry)
    except ValueError as error:
        raise document.error(("specimens",), str(error)) from error
    if not path.is_file():
        raise document.error(("specimens",), f"no file {path}")
    file = read_document(document.path.parent / relative_path(entry), SpecimensFile)
    return _table(file, file.value.joints, ("joints",))


def _table(
    document: Document[LogSection] | Document[SpecimensFile],
    joints: Mapping[str, Mapping[str, SpecimenSection]],
    place: tuple[Key, ...],
) -> Table:
    return {
        (joint, name): _specimen(document, section, joint, name, (*place, joint, name))
        for joint, names in joints.items()
        for name, section in names.items()
    }


def _specimen(
    document: Document[LogSection] | Document[SpecimensFile],
    section: SpecimenSection,
    joint: str,
    name: str,
    place: tuple[Key, ...],
) -> Specimen:
    """Return one specimen, its clearances worked out from its dimensions.

    Raises
    ------
    DocumentError
        If the hole is smaller than the bushing, or a clearance is given twice and differs.
    """
    actual = section.clearance
    if section.hole is not None and section.bushing is not None:
        measured = round(section.hole - section.bushing, 12)
        if measured < 0.0:
            raise document.error(
                (*place, "bushing"), "expected a bushing that is not larger than the hole"
            )
        if actual is not None and abs(actual - measured) > 1e-9:
            raise document.error(
                (*place, "clearance"),
                f"expected hole less bushing, {measured * 1e3:g} mm; leave one of them out",
            )
        actual = measured
    axial = None
    if section.thickness is not None and section.bushing_thickness is not None:
        axial = max(0.0, round(section.bushing_thickness - section.thickness, 12))
    return Specimen(
        joint, name, section.nominal, actual, axial, section.material or "", section.comment
    )
