"""What a reader says of odd input: one sentence, and soon."""

import time

from smoothprofile.errors import CaseError

LONGEST = 15.0
"""Seconds of this process: hangs take minutes, and busy neighbours slow it down to a fifth."""


def sentence_of(read):
    """What it refused, or None if it took it; nothing else, and soon."""
    began, sentence = time.process_time(), None
    try:
        read()
    except CaseError as error:
        sentence = str(error)
    assert time.process_time() - began < LONGEST
    if sentence is not None:
        assert sentence and "\n" not in sentence and "Traceback" not in sentence, sentence
    return sentence
