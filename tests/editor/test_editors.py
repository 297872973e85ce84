"""What `editors/` holds agrees with itself and with the language."""

import json
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

EDITORS = Path(__file__).resolve().parents[2] / "editors"
VSCODE = EDITORS / "vscode"
MANIFEST = json.loads((VSCODE / "package.json").read_text(encoding="utf-8"))
LANGUAGES = {"exo": ".exo", "exo-properties": ".prop"}


def test_the_extension_is_for_both_languages_and_has_its_files() -> None:
    contributed = MANIFEST["contributes"]
    assert {each["id"]: each["extensions"][0] for each in contributed["languages"]} == LANGUAGES
    for each in contributed["languages"]:
        json.loads((VSCODE / each["configuration"]).read_text(encoding="utf-8"))
    for each in contributed["grammars"]:
        grammar = json.loads((VSCODE / each["path"]).read_text(encoding="utf-8"))
        assert each["language"] in LANGUAGES and grammar["scopeName"] == each["scopeName"]
    assert (VSCODE / MANIFEST["main"]).is_file()


def test_what_the_extension_needs_is_pinned() -> None:
    lock = json.loads((VSCODE / "package-lock.json").read_text(encoding="utf-8"))
    for name, version in (MANIFEST["dependencies"] | MANIFEST["devDependencies"]).items():
        assert re.fullmatch(r"\d+\.\d+\.\d+", version)
        assert lock["packages"][f"node_modules/{name}"]["version"] == version
    assert all("integrity" in each for path, each in lock["packages"].items() if path)


@pytest.mark.skipif(shutil.which("node") is None, reason="there is no Node.js")
def test_the_client_starts_the_server_as_the_settings_say() -> None:
    command = ["node", str(Path(__file__).with_name("extension.cjs")), str(VSCODE / MANIFEST["main"])]
    ended = subprocess.run(command, check=True, timeout=60, capture_output=True, text=True)
    found = json.loads(ended.stdout)
    (_, name, server, client), *rest = found["said"]
    assert name == "exover" and server == {"command": "here/exover", "args": ["lsp"]}
    assert client["initializationOptions"] == {"checkSeconds": 3}
    assert [each["language"] for each in client["documentSelector"]] == list(LANGUAGES)
    assert [each[0] for each in rest] == ["start", "stop", "new", "start", "stop", "new", "start", "error", "stop"]
    (complaint,) = [each[1] for each in rest if each[0] == "error"]
    assert "nothing cannot be started: ENOENT" in complaint and "pip install 'exover[lsp]'" in complaint
    assert found["subscriptions"] == 2


def test_helix_is_for_both_languages() -> None:
    config = tomllib.loads((EDITORS / "helix.toml").read_text(encoding="utf-8"))
    assert {each["name"]: f".{each['file-types'][0]}" for each in config["language"]} == LANGUAGES
    assert all(each["language-servers"] == ["exover"] for each in config["language"])
    server = config["language-server"]["exover"]
    assert [server["command"], *server["args"]] == ["exover", "lsp"]
