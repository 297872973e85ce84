"""`exover completion` as shells use it."""

import shutil
import subprocess
from pathlib import Path

import pytest

from exover.cli.options import TARGETS
from exover.cli.values import REPORT_FORMATS

SHELLS = ("bash", "zsh", "fish")
ASK = """
source {script}
COMP_WORDS=({words}) COMP_CWORD=$(({count} - 1)) COMP_LINE="{words}" COMP_POINT=${{#COMP_LINE}}
eval "$(complete -p exover | sed 's/.*-F \\([^ ]*\\).*/\\1/')"
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["exover", "ch"], {"check"}),
        (["exover", "check", "--fo"], {"--format"}),
        (["exover", "check", "--format", "s"], {"sarif"}),
        (["exover", "emit", "--target", "ru"], {"rust"}),
        (["exover", "check", "de"], {"demo.exo"}),
        (["exover", "check", "--only", "lock"], {"lockout"}),
        (["exover", "check", "--skip", "safety,lock"], {"safety,lockout"}),
        (["exover", "check", "--skip", "safety,war"], {"safety,warning"}),
        (["exover", "emit", "--target", "c,ru"], {"c,rust"}),
        (["exover", "emit", "--target", "c,"], {f"c,{each}" for each in TARGETS}),
        (["exover", "graph", "--only", "wakes,excl"], {"wakes,excludes"}),
        (["exover", "trace", "--check", "lock"], {"lockout"}),
        (["exover", "docs", "certi"], {"certificates"}),
        (["exover", "explain", "E10"], {f"E10{number}" for number in range(1, 10)}),
        (["exover", "explain", "lock"], {"lockout"}),
        (["exover", "explain", "de"], {"deadlock", "demo.exo"}),
        (["exover", "check", "demo.exo", "--format", "=", "s"], {"sarif"}),
        (["exover", "check", "demo.exo", "--format", "="], {*REPORT_FORMATS}),
        (["exover", "check", "--format", "=", "json", "de"], {"demo.exo"}),
        (["exover", "completion", ""], {"bash", "zsh", "fish"}),
    ],
)
def test_bash_completes(run, spec: Path, words: list[str], expected: set[str]) -> None:
    script = spec.parent / "exover.bash"
    script.write_text(run("completion", "bash").stdout)
    text = ASK.format(script=script, words=" ".join(word or "''" for word in words), count=len(words))
    done = subprocess.run(["bash", "-c", text], cwd=spec.parent, capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) == expected, done.stderr


@pytest.mark.parametrize("shell", SHELLS)
def test_every_verb_is_in_the_script_and_the_shell_reads_it(run, tmp_path: Path, shell: str) -> None:
    done = run("completion", shell)
    assert (done.returncode, done.stderr) == (0, "")
    for word in ("check", "verify", "simulate", "trace", "explain", "emit", "doctor", "help", "sarif"):
        assert word in done.stdout
    if shutil.which(shell):
        path = tmp_path / "script"
        path.write_text(done.stdout)
        subprocess.run([shell, "-n", str(path)], check=True)
