"""Texts that are nearly of the language: random tokens, and files with tokens dropped, doubled, moved or cut out."""

from collections.abc import Sequence

from hypothesis import strategies as st

ODD = ["\n", "$", '"', "/*", "\0", "9x", "é"]
"""What is no token, or part of one."""


def any_words(tokens: Sequence[str]) -> st.SearchStrategy[list[str]]:
    """Return a strategy of words in any order."""
    return st.lists(st.sampled_from([*sorted(set(tokens)), *ODD]), max_size=60)


@st.composite
def mutations(draw: st.DrawFn, tokens: Sequence[str]) -> list[str]:
    """Draw the words of a file after one to six changes."""
    words = list(tokens)
    for _ in range(draw(st.integers(1, 6))):
        at = draw(st.integers(0, len(words) - 1))
        match draw(st.sampled_from(["drop", "double", "move", "cut"])):
            case "drop":
                del words[at]
            case "double":
                words.insert(at, words[at])
            case "move":
                words.insert(draw(st.integers(0, len(words) - 1)), words.pop(at))
            case "cut":
                del words[at : at + draw(st.integers(0, 40))]
        words = words or ["x"]
    return words
