"""Whole files and safe names."""

from __future__ import annotations

import errno
import unicodedata
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lelight.errors import OutputError
from lelight.writing.files import (
    NAME_BYTES,
    discard_unfinished,
    make_folder,
    safe_name,
    safe_names,
    whole,
    write_text,
)


def test_a_file_appears_under_its_name_and_nothing_else_stays(tmp_path):
    target = tmp_path / "Büro 1 ☀.vtp"
    with whole(target) as beside:
        assert beside.parent == tmp_path and beside.suffix == ".vtp"
        beside.write_bytes(b"light")
        assert not target.exists()
    assert [file.name for file in tmp_path.iterdir()] == [target.name]
    assert target.read_bytes() == b"light"


@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt])
def test_a_failure_leaves_the_old_file_and_no_debris(tmp_path, failure):
    target = tmp_path / "run.json"
    write_text(target, "old")
    with pytest.raises(failure), whole(target) as beside:
        beside.write_text("half", encoding="utf-8")
        raise failure
    assert [file.name for file in tmp_path.iterdir()] == ["run.json"]
    assert target.read_text(encoding="utf-8") == "old"


def test_a_process_that_does_not_unwind_leaves_no_debris_either(tmp_path):
    write_text(tmp_path / "run.json", "old")
    with suppress(OutputError), whole(tmp_path / "run.json") as beside:
        beside.write_text("half", encoding="utf-8")
        discard_unfinished()
        assert [file.name for file in tmp_path.iterdir()] == ["run.json"]
    assert (tmp_path / "run.json").read_text(encoding="utf-8") == "old"


@pytest.mark.parametrize(
    ("number", "remedy"),
    [(errno.ENOSPC, "free some space"), (errno.EACCES, "may write to"), (errno.EROFS, "another folder")],
)
def test_what_the_system_refuses_becomes_one_line_with_the_remedy(tmp_path, number, remedy):
    target = tmp_path / "field.vtp"
    with pytest.raises(OutputError, match=remedy) as caught, whole(target):
        raise OSError(number, "refused")
    assert str(caught.value).startswith(f"{target}: ") and "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_gone_or_is_a_file_is_named(tmp_path):
    with pytest.raises(OutputError, match="folder does not exist"):
        write_text(tmp_path / "gone" / "run.json", "{}")
    write_text(tmp_path / "file", "")
    with pytest.raises(OutputError, match="is a file, not a folder"):
        write_text(tmp_path / "file" / "run.json", "{}")
    with pytest.raises(OutputError, match="a file stands where the folder should be"):
        make_folder(tmp_path / "file")
    (tmp_path / "run.json").mkdir()
    with pytest.raises(OutputError, match="a folder has this name"):
        write_text(tmp_path / "run.json", "{}")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "run.json"]


@pytest.mark.parametrize(
    ("name", "safe"),
    [
        ("desk 1", "desk 1"),
        ("Bu\u0308ro", "B\u00fcro"),
        ("日本語", "日本語"),
        ("../../etc/passwd", "_.._etc_passwd"),
        ("C:\\temp", "C__temp"),
        (".hidden", "hidden"),
        ("-rf", "rf"),
        ("a\x00b\x7f", "a_b_"),
        (" two\n lines ", "two lines"),
        ("", "unnamed"),
        ("...", "unnamed"),
        ("\ud800", "_"),
        ("NUL", "_NUL"),
        ("com1.txt", "_com1.txt"),
        ("$(reboot)", "_(reboot)"),
    ],
)
def test_names_are_made_safe(name, safe):
    assert safe_name(name) == safe


any_name = st.text(st.characters(), max_size=300)


@given(any_name)
def test_a_safe_name_is_one_path_part_and_stays_as_it_is(name):
    safe = safe_name(name)
    assert 0 < len(safe.encode()) <= NAME_BYTES
    assert not set(safe) & set("/\\:*?\"'<>|$`") and safe[0] not in ".-~ " and safe[-1] not in ". "
    assert all(unicodedata.category(sign)[0] != "C" for sign in safe)
    assert safe_name(safe) == safe


@given(st.lists(st.one_of(any_name, st.sampled_from(["a", "A", "a-2", "", "x" * 200])), max_size=12))
def test_safe_names_differ_and_do_not_depend_on_what_follows(names):
    unique = safe_names(names)
    assert len({name.casefold() for name in unique}) == len(names)
    assert all(len(name.encode()) <= NAME_BYTES for name in unique)
    assert safe_names(names[:-1]) == unique[:-1]


def test_the_first_of_equal_names_keeps_it():
    assert safe_names(["desk", "Desk", "desk-2", "desk"]) == ("desk", "Desk-2", "desk-2-2", "desk-3")
