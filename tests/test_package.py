"""What is installed: the mapping of folders to packages, versions, and how soon an import is done."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest

import lelight

ROOT = Path(__file__).parents[1]
#: Top-level folders that are packages below ``lelight``.
LINKED = ("cli", "pipelines", "reports")

#: Packages that take long to import, and that neither ``import lelight`` nor its help need.
HEAVY = {
    *("numba", "scipy", "vtk", "vtkmodules", "pyvista", "matplotlib", "pymeshlab", "typst"),
    *("OpenImageIO", "embreex", "ducc0", "pydantic", "rich"),
}

#: Files of the physics that are no modules.
OWN_DATA = (Path("lelight/py.typed"), Path("lelight/metrics/metrics.schema.json"))


@pytest.fixture(scope="module")
def project():
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def home_of(package: str, homes: dict[str, str]) -> Path:
    """Folder of a package by setuptools' rule: the longest mapped parent, then the names below it."""
    parts = package.split(".")
    for length in range(len(parts), 0, -1):
        parent = ".".join(parts[:length])
        if parent in homes:
            return Path(homes[parent], *parts[length:])
    return Path(*parts)


def python_folders() -> set[Path]:
    """Folders of the tree with modules in them, links not followed."""
    modules = [
        Path(folder, name)
        for top in ("lelight", *LINKED)
        for folder, _, names in os.walk(ROOT / top, followlinks=False)
        for name in names
        if name.endswith(".py")
    ]
    return {module.parent.relative_to(ROOT) for module in modules}


def test_mapping_covers_the_tree(project):
    tools = project["tool"]["setuptools"]
    homes = {package: home_of(package, tools["package-dir"]) for package in tools["packages"]}
    assert len(set(homes)) == len(tools["packages"])
    assert set(homes.values()) == python_folders()
    for package, home in homes.items():
        assert (ROOT / home / "__init__.py").is_file(), package
        if home.parts[0] in LINKED:
            assert package == ".".join(("lelight", *home.parts))
        else:
            assert package == ".".join(home.parts)


def test_links_lead_where_the_mapping_says(project):
    homes = project["tool"]["setuptools"]["package-dir"]
    links = {path.name: path.readlink() for path in (ROOT / "lelight").iterdir() if path.is_symlink()}
    assert links == {name: Path("..", name) for name in LINKED}
    for name in LINKED:
        assert homes[f"lelight.{name}"] == name
        assert (ROOT / "lelight" / name).resolve() == ROOT / name


def test_nothing_else_may_be_installed(project):
    tools = project["tool"]["setuptools"]
    assert set(tools) == {"packages", "package-dir", "package-data", "include-package-data"}
    assert tools["include-package-data"] is False
    assert {package.split(".")[0] for package in tools["packages"]} == {"lelight"}
    assert project["project"]["scripts"] == {"lelight": "lelight.cli.main:main"}


def test_data_of_the_packages_is_declared(project):
    tools = project["tool"]["setuptools"]
    declared = {
        path
        for package, patterns in tools["package-data"].items()
        for pattern in patterns
        for path in (ROOT / home_of(package, tools["package-dir"])).glob(pattern)
    }
    templates = {path for folder in ("templates", "texts") for path in (ROOT / "reports" / folder).iterdir()}
    assert templates
    assert declared == {*(ROOT / path for path in OWN_DATA), *templates}


def test_wheel_holds_the_package_and_nothing_else(project, tmp_path):
    pytest.importorskip("setuptools")
    if int(version("setuptools").split(".")[0]) < 77:
        pytest.skip("building needs setuptools 77, as pyproject.toml says")
    tree = tmp_path / "tree"
    ignored = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info", "build", "dist", "scenes", "tests")
    shutil.copytree(ROOT, tree, symlinks=True, ignore=ignored)
    script = "import sys; from setuptools.build_meta import build_wheel; build_wheel(sys.argv[1])"
    subprocess.run([sys.executable, "-c", script, tmp_path], cwd=tree, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    modules = {path.relative_to(ROOT) for folder in python_folders() for path in (ROOT / folder).glob("*.py")}
    data = {*OWN_DATA, *(path.relative_to(ROOT) for path in ROOT.glob("reports/te*/*.t*"))}
    expected = {path if path.parts[0] == "lelight" else Path("lelight", path) for path in modules | data}
    assert names == {path.as_posix() for path in expected}


def test_versions_agree(project):
    assert project["project"]["version"] == lelight.__version__ == version("lelight")


def in_fresh_process(code: str) -> tuple[str, float]:
    """What a fresh interpreter prints, and the seconds of processor time that it took."""
    before = os.times()
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    after = os.times()
    spent = after.children_user + after.children_system - before.children_user - before.children_system
    return run.stdout, spent


HELP = "from lelight.cli.main import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"


@pytest.mark.parametrize(("code", "limit"), [("import lelight", 0.5), (HELP, 0.3)], ids=["import", "help"])
def test_import_and_help_come_at_once(code, limit):
    # Processor time instead of the clock's, and the best of three: other work on the machine does not count.
    assert min(in_fresh_process(code)[1] for _ in range(3)) < limit


@pytest.mark.parametrize(
    ("code", "too_heavy"),
    [("import lelight", HEAVY | {"click"}), (HELP, HEAVY | {"numpy"})],
    ids=["import", "help"],
)
def test_import_and_help_load_no_engine(code, too_heavy):
    told, _ = in_fresh_process(f"{code}\nimport sys\nprint('LOADED', *sys.modules)")
    loaded = {name.split(".")[0] for name in told.partition("LOADED ")[2].split()}
    assert "lelight" in loaded
    assert loaded & too_heavy == set()


def test_every_public_name_can_be_imported():
    told, _ = in_fresh_process(
        "import lelight\nprint(*[getattr(lelight, name).__module__ for name in sorted(lelight._HOMES)])"
    )
    assert told.split() == [lelight._HOMES[name] for name in sorted(lelight._HOMES)]


def test_physics_do_not_know_the_command_line():
    code = "import lelight.calculation, sys; print(*sys.modules)"
    loaded = in_fresh_process(code)[0].split()
    assert [name for name in loaded if name.split(".")[0] in {"click", "typst"}] == []
    assert [name for name in loaded if name.startswith(tuple(f"lelight.{name}" for name in LINKED))] == []
