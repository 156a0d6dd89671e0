"""Read what crossgrain writes into numpy and pandas: run folders, records of jobs, rows of studies.

    import crossgrain
    run = crossgrain.read_run("out")
    run.positions                   # numpy, (N, 2), m
    run.table("contacts")           # pandas
    crossgrain.read_record("verify.json").checks
    crossgrain.read_rows("campaign")

Numbers have the bits of the files. SI units; x across, z up; grains have the ids 0 … N−1, in the order of the rows.
Nothing is believed that is not as it was written: files are held against their SHA-256. Needs numpy and pandas.
"""
import gzip
import hashlib
import io
import json
import pathlib
from dataclasses import dataclass

import numpy
import pandas

RUN_VERSION = 4
RECORD_VERSIONS = (1, 2)
SEAL = ',\n  "record_digest": "'
# Names and digests: a digest of figures alone is no number.
WORDS = {"stage": str, "state": str}


class CrossgrainError(ValueError):
    """What cannot be read, why, and what to do, in one sentence."""


def _bytes(path):
    """What a file or its packed sibling holds: the bytes as they stand, and unpacked."""
    for there in (path, path.with_name(path.name + ".gz")):
        try:
            stored = there.read_bytes()
            return stored, gzip.decompress(stored) if there.suffix == ".gz" else stored
        except FileNotFoundError:
            continue
        except (OSError, EOFError, gzip.zlib.error) as error:
            raise CrossgrainError(f"{there} cannot be read: {error}; make it anew") from error
    raise CrossgrainError(f"{path} does not exist; give the path of a finished run, study or record")


def _json(text, path):
    try:
        return json.loads(text)
    except ValueError as error:
        raise CrossgrainError(f"{path} is no JSON: {error}; make it anew") from error


def _sha256(of):
    return hashlib.sha256(of).hexdigest()


def _table(text, path):
    try:
        # Only this parser gives the nearest number.
        return pandas.read_csv(io.BytesIO(text), dtype=WORDS, float_precision="round_trip")
    except ValueError as error:
        raise CrossgrainError(f"{path} is no table: {error}; make it anew") from error


@dataclass(frozen=True)
class Run:
    """A run folder (docs/run-folder.md) whose files are as they were written."""

    folder: pathlib.Path
    #: `run.json`.
    record: dict
    #: `scene.json`, every default stated.
    scene: dict
    #: The text of each file by its name, tables unpacked.
    files: dict

    def table(self, name):
        """A table as a DataFrame: `initial`, `bodies`, `contacts`, `memory`, `settled-bodies`, `settled-contacts`,
        `settled-memory`, `history` or `trace`; columns and units are those of docs/run-folder.md, an empty cell is NaN."""
        text = self.files.get(f"{name}.csv")
        if text is None:
            there = ", ".join(sorted(of[:-4] for of in self.files if of.endswith(".csv")))
            raise CrossgrainError(f"{self.folder} has no table {name!r}; it has {there}")
        return _table(text, self.folder / f"{name}.csv")

    def _columns(self, *names):
        return self.table("bodies")[list(names)].to_numpy(dtype=numpy.float64)

    @property
    def positions(self):
        """Centres of the grains at the end, (N, 2): x and z, m."""
        return self._columns("x", "z")

    @property
    def velocities(self):
        """Of the grains at the end, half a step behind the positions, (N, 2): x and z, m/s."""
        return self._columns("vx", "vz")

    @property
    def radii(self):
        """(N,), m."""
        return self._columns("radius")[:, 0]

    @property
    def masses(self):
        """(N,), kg."""
        return self._columns("mass")[:, 0]

    @property
    def measures(self):
        """What was measured of the settled and the last bed: a Series by key; units are in `record["measures"]`."""
        return pandas.Series({of["key"]: of["value"] for of in self.record["measures"]}, dtype=float)

    @property
    def fabric(self):
        """The mean of n⊗n over the contacts at the end, (2, 2), of trace 1; NaN without contacts."""
        normals = self.table("contacts")[["nx", "nz"]].to_numpy(dtype=numpy.float64)
        return normals.T @ normals / len(normals) if len(normals) else numpy.full((2, 2), numpy.nan)


def read_run(folder):
    """The run in a folder that `crossgrain run` has written."""
    folder = pathlib.Path(folder)
    if not (folder / "SHA256SUMS").is_file() or not (folder / "run.json").is_file():
        raise CrossgrainError(f"{folder} is no run folder: it lacks SHA256SUMS or run.json; give one that `crossgrain run` wrote")
    files = {}
    for line in _bytes(folder / "SHA256SUMS")[1].decode("utf-8", "replace").splitlines():
        digest, _, name = line.partition("  ")
        if not name or "/" in name or name.startswith("."):
            raise CrossgrainError(f"{folder}: SHA256SUMS has a line that is no digest and name: {line!r}; run it again")
        stored, text = _bytes(folder / name)
        # Who packs a table afterwards leaves its text as it is.
        if digest not in (_sha256(stored), _sha256(text)):
            raise CrossgrainError(f"{folder / name} was changed after it was written; put back what was there, or run it again")
        files[name.removesuffix(".gz")] = text
    record, scene = (_json(files.get(name, b""), folder / name) for name in ("run.json", "scene.json"))
    if record.get("version") != RUN_VERSION:
        raise CrossgrainError(f"{folder} has version {record.get('version')}, and this module reads {RUN_VERSION}; run it again")
    return Run(folder, record, scene, files)


@dataclass(frozen=True)
class Record:
    """What a job found (docs/record.schema.json)."""

    #: Every key of the file.
    all: dict

    @property
    def verdict(self):
        """`pass`, `fail` or `skipped`."""
        return self.all["verdict"]

    @property
    def checks(self):
        """A row a check: id, quantity, unit, value, expected, lower, upper, outcome, …; a check without a number has NaN."""
        return pandas.DataFrame(self.all["checks"])

    @property
    def measured(self):
        """A row a quantity that was measured and is judged by nothing."""
        return pandas.DataFrame(self.all.get("measured", []))


def read_record(path):
    """The record of a job: verify.json, bench.json, report.json or the main job's run.json, packed or not."""
    path = pathlib.Path(path)
    stored, text = _bytes(path)
    text = text.decode("utf-8", "replace")
    found = _json(text, path)
    if not isinstance(found, dict) or "job" not in found or "checks" not in found:
        raise CrossgrainError(f"{path} is no record of a job; give verify.json, bench.json or report.json, or a run folder to read_run")
    if found.get("version") not in RECORD_VERSIONS:
        raise CrossgrainError(f"{path} is of version {found.get('version')}, which this module does not know; use a newer one")
    body, _, seal = text.rpartition(SEAL)
    if found["version"] > 1 and seal != _sha256(body.encode()) + '"\n}\n':
        raise CrossgrainError(f"{path} was changed after it was written; put back what was there, or do the job again")
    return Record(found)


def read_rows(folder):
    """The rows of a merged study, a DataFrame with a row each; nested keys have dots, as in `measured.loaded.height.mean_surface`,
    and lists stay lists."""
    folder = pathlib.Path(folder)
    summary = _json(_bytes(folder / "merged.json")[1], folder / "merged.json")
    text = _bytes(folder / "rows.jsonl")[1]
    if _sha256(text) != summary.get("sha256"):
        raise CrossgrainError(f"{folder / 'rows.jsonl'} is not what merged.json says; merge the study again")
    return pandas.json_normalize([json.loads(line) for line in text.splitlines()])
