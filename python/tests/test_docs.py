"""The examples of the tutorial, in their order."""

import re
import shutil
import warnings

import pytest
from conftest import LENS, REPOSITORY

PAGE = REPOSITORY / "docs/guide/python.md"
EXAMPLE = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def examples():
    text = PAGE.read_text(encoding="utf-8")
    return [(text[: found.start()].count("\n"), found[1]) for found in EXAMPLE.finditer(text)]


def test_the_examples_of_the_tutorial(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "demo").mkdir()
    shutil.copy(LENS, tmp_path / "demo/lens.json")
    found, names, left_out = examples(), {}, []
    assert len(found) >= 10
    for line, code in found:
        # So that messages name the line of the page.
        compiled = compile("\n" * (line + 1) + code, PAGE, "exec")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            try:
                exec(compiled, names)
            except ModuleNotFoundError as error:
                left_out.append(f"line {line + 1} needs {error.name}")
    if left_out:
        pytest.skip(f"not all examples were run: {', '.join(left_out)}, which is not installed")


def test_every_name_is_documented():
    import seidel

    for name in seidel.__all__:
        documented = getattr(seidel, name)
        if name != "__version__":
            assert documented.__doc__, name
            for inner in vars(documented) if isinstance(documented, type) else ():
                if not inner.startswith("_") and callable(getattr(documented, inner)):
                    assert getattr(documented, inner).__doc__, f"{name}.{inner}"
