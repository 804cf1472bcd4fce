"""Studies: the same question of many scenes, beside published answers."""

from thermo.study._case import Case, truth
from thermo.study._case_study import study_case
from thermo.study._ensemble import Ensemble, Member, ensemble_record, gather, read_members
from thermo.study._paper import ROWS, TABLE_ONE, Row
from thermo.study._paper_cases import paper_cases
from thermo.study._preset import PRESETS, Preset
from thermo.study._study import study
from thermo.study._tables import write_tables

__all__ = [
    "PRESETS",
    "ROWS",
    "TABLE_ONE",
    "Case",
    "Ensemble",
    "Member",
    "Preset",
    "Row",
    "ensemble_record",
    "gather",
    "paper_cases",
    "read_members",
    "study",
    "study_case",
    "truth",
    "write_tables",
]
