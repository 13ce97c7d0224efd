"""Records: what a piece of work found, as a file can hold it, and the way back to what it was."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any, Generic, TypeVar, get_type_hints

import numpy as np
from numpy.typing import NDArray

Found = TypeVar("Found")


@dataclass(frozen=True)
class Record:
    """Numbers in arrays, and what JSON can hold beside them."""

    values: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class Form(Generic[Found]):
    """How one kind of finding becomes a record and back.

    Attributes
    ----------
    pack, unpack : the two ways; ``unpack`` raises KeyError, TypeError or ValueError where a record is not of its kind
    """

    pack: Callable[[Found], Record]
    unpack: Callable[[Record], Found]


def form_of(kind: type[Found]) -> Form[Found]:
    """Form of a dataclass whose fields are arrays, numbers, texts, and dataclasses of such."""
    return Form(_packed, lambda record: _unpacked(kind, record, ""))


#: Form of a single array.
ARRAY: Form[NDArray[Any]] = Form(lambda found: Record(arrays={"": found}), lambda record: record.arrays[""])


def _packed(found: Any) -> Record:
    values: dict[str, Any] = {}
    arrays: dict[str, NDArray[Any]] = {}
    for each in fields(found):
        content = getattr(found, each.name)
        if isinstance(content, np.ndarray):
            arrays[each.name] = content
        elif is_dataclass(content):
            inner = _packed(content)
            values.update({f"{each.name}.{name}": value for name, value in inner.values.items()})
            arrays.update({f"{each.name}.{name}": array for name, array in inner.arrays.items()})
        else:
            values[each.name] = content.item() if isinstance(content, np.generic) else content
    return Record(values, arrays)


def _unpacked(kind: type[Any], record: Record, prefix: str) -> Any:
    hints = get_type_hints(kind)
    content = {}
    for each in fields(kind):
        name = prefix + each.name
        if is_dataclass(hints[each.name]):
            content[each.name] = _unpacked(hints[each.name], record, f"{name}.")
        else:
            content[each.name] = record.arrays[name] if name in record.arrays else record.values[name]
    return kind(**content)
