"""A limit on everything that a script waits for. Playwright waits without end for what runs in a page, for printing, and for closing; where one call
takes too long, the place is printed, the browser is ended, and the script fails."""

import glob
import os
import signal
import socket
import sys
import threading
import time
import traceback
from pathlib import Path

import greenlet

# Seconds: one call, which is more than what Playwright waits for by itself; and a whole script, whose place is printed before `main.rs` ends it.
LONGEST_CALL = 150
LONGEST_SCRIPT = 590
FOLDER = str(Path(__file__).parent)


def watch(longest=LONGEST_CALL):
    """Watches the calls of the thread and greenlet that calls this, until the process ends."""
    socket.setdefaulttimeout(longest)
    script = (greenlet.getcurrent(), threading.get_ident())
    threading.Thread(target=follow, args=(script, longest), daemon=True).start()


def follow(script, longest):
    begun = since = time.monotonic()
    known, reported = None, False
    while True:
        time.sleep(1)
        now = time.monotonic()
        if (place := where(script)) != known:
            known, since = place, now
        if now - since > longest:
            end(script, f"no answer within {longest} s")
        if now - begun > LONGEST_SCRIPT and not reported:
            reported = True
            tell(script, f"not done after {LONGEST_SCRIPT} s")


def stack(script):
    """Frames of the script itself: while it waits, those of Playwright's loop are on the thread, and its own are put aside."""
    own, thread = script
    frame = own.gr_frame or sys._current_frames().get(thread)
    return traceback.extract_stack(frame)


def where(script):
    return [(f.filename, f.lineno) for f in stack(script) if f.filename.startswith(FOLDER)]


def tell(script, what):
    print(f"{what}:\n{''.join(traceback.format_list(stack(script)))}", file=sys.stderr, flush=True)


def end(script, what):
    tell(script, what)
    # What the script began would keep its output open.
    for child in reversed(descendants(os.getpid())):
        try:
            os.kill(child, signal.SIGKILL)
        except ProcessLookupError:
            pass
    os._exit(1)


def descendants(process):
    children = [int(child) for path in glob.glob(f"/proc/{process}/task/*/children") for child in text(path).split()]
    return children + [below for child in children for below in descendants(child)]


def text(path):
    """Empty where the process has ended meanwhile."""
    try:
        return Path(path).read_text()
    except OSError:
        return ""
