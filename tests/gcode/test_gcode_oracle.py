# SPDX-License-Identifier: Apache-2.0
"""Every feature of the interpreter against LinuxCNC's interpreter rs274: equal moves."""

import pytest

from sim.motion.gcode import oracle
from sim.motion.gcode.interpreter import GcodeErrors, parse
from sim.motion.gcode.oracle import (
    UNKNOWN,
    OracleError,
    Samples,
    _aligned,
    compare_samples,
    differences,
    machine_records,
    ours,
    rs274,
)
from tests.bench.needs import needs

pytestmark = needs("rs274")

HEAD = "G21 G90 G17 G94 G54 G98\n"
PROGRAMS = {
    "lines and rapids": "G0 X1 Y2 Z3\nG1 X-4.5 F200\nY7 A10 C-30\nG0 A0\nG1 C90 F500",
    "arcs by centre": "G1 X10 F300\nG2 X0 Y-10 I-10 J0\nG3 X10 Y0 I0 J10 Z5\nG3 I-10",
    "arcs by radius": "G1 X10 F300\nG2 X0 Y-10 R-10\nG3 X3 Y-4 R8\nG2 X10 Y0 Z-2 R20",
    "planes": "G18 G1 X5 F100\nG2 X0 Z5 I-5\nG3 X5 Z0 I0 K-5 Y2\nG19 G2 Y4 Z2 J1 K1\nG17",
    "inches": "G20 G0 X1 Y.5\nG1 X2 F10\nG2 X3 I.5\nG21\nG1 X5 F100",
    "incremental": "G91 G1 X1 Y2 F100\nX1\nG2 X2 I1\nG90 X0 Y0 R5\nG91 G0 Z-1 A5\nC7",
    "absolute centres": "G90.1 G0 X5 Y5\nG2 X7 Y5 I6 J5 F100\nG91.1 G2 X9 I1",
    "dwell": "G4 P.25\nG1 X1 F100\nG4 P1\nX2",
    "home": "G0 X5 Y6 Z7 A8\nG28 Z9\nG1 X4 F100\nG28\nG91 G28 X1 Y1\nG90 G28 A3 C4",
    "home stored": "G0 X2 Y3 Z4 A5\nG28.1\nG0 X9\nG28 X8\nG0 Y1\nG28",
    "threads": (
        "S400 M3 G0 X2 Z1\nG33 Z-5 K1.25\nX3 Z-6 K.5\nM4 S100 G33 X4 A2 C1 K2\nG1 X1 F50\n"
        "G20 G33 Z-1 K.1\nG21 G0 Z9\nG33.1 X5 Z-3 K1.5\nG0 X1\nG33.1 X9 K2\nG1 Y3"
    ),
    "saved spindle": "S400 M3\nM70\nM5\nS7\nM72\nG33 Z-5 K1.25\nG0 X1",
    "probing": (
        "G38.2 Z-5 F100\nG1 X1 Z#5063\nG38.3 X9 Z-7\nX[#5061+2] Y[#5070+3]\nG38.5 Z4 A3\nG0 X2 Y2"
        " Z2\nG92 X1 Y1\nG38.4 X5 F30\nG0 Y#5061 X#5062\nG20 G38.2 X1\nG1 Y#5061 X#5065 Z1"
    ),
    "feed per turn": (
        "G95 M3 S100 F.2\nG1 X3\nS200 X4\nG2 X5 Y1 R3\nG93 G1 X9 F3\nG95 F.5\nG83 X1 Z-1 R1 Q.7\n"
        "G80\nG33 Z-5 K1.25\nG94 G1 X1 F30"
    ),
    "constant speed of the spindle": "G97 S300 M3\nG33 Z-5 K1.25",
    "oriented spindle": "M19\nM19 R45 Q2\nG1 X1 F100\nM19 P1 X3",
    "outputs": "M62 P1\nG1 X1 F100\nM63 P1 X3\nM64 P0\nM65 P0\nM67 E0 Q2.5\nM68 E1 Q-1\nX5",
    "input": "G1 X1 F100\nM66 P0 L0\nX3\nM66 E1\nX2",
    "local system": (
        "G52 X2 Y3\nG0 X1 Y1\nG52 X5\nG0 X1 Y1\nG92 X0\nG0 X1 Y1\nG52 X0 Y0\nX1 Y1\n"
        "G92 X7 Y7\nG52 X1\nX0 Y0\nG92.2\nX0 Y0\nG92.3\nX0 Y0"
    ),
    "local system, rotated": "G10 L2 P1 X10 R30\nG52 X2 Y3\nG0 X1 Y1\nG92 X0\nX1 Y1 Z2 A3",
    "tool mounted before": "M61 Q2\nG43\nG0 X1 Z1\nM61 Q[1+2] G43\nX2 Z2\nM61 Q0 X3\nG49 Z3",
    "data of tools": (
        "G10 L1 P1 X1 Y2 Z3\nT1 M6\nG43\nG0 X1 Y1 Z1\nG10 L1 P1 Z7\nX2 Z2\nG43\nX3 Z3 A1\n"
        "G10 L10 P1 X0 Z1\nG43\nX1 Y1 Z1\nG10 L1 P2 X4 R3\nG43 H2\nX2"
    ),
    "data of tools, rotated": (
        "T1 M6\nG43\nG10 L2 P1 X1 R45\nG0 X10 Y20 Z3\nG10 L11 P1 X4 Z9\nG43\nX1 Y0\n"
        "G10 L2 P9 X3 Y9 R30\nG52 X3\nG10 L11 P1 X4 Z9\nG43\nX1 Y0\nG10 L10 P1 Y4 Z9\nG43\n"
        "X1 Y0\nG10 L10 P1 X4 Y2\nG43\nX2 Y0"
    ),
    "arcs of rotated planes": (
        "G10 L2 P1 X3 Y-2 Z1 R30\nG0 X1 Y2 Z3\nF500\nG18 G2 X5 Z3 I2 K0\nG3 X5 Z6 R4 Y5\n"
        "G19 G2 Y9 Z6 J2 K0.5\nG3 Y9 Z8 K1 J0 P2 X8\nG2 Y9.01 Z8.02 J5 K0\nG10 L2 P1 R90\n"
        "G18 G0 X0 Z0\nG3 X4 Z2 I2 K1 A5"
    ),
    "state shown by parameters": (
        "G1 X#<_metric> Y#<_absolute> Z#<_task> F100\nX#<_lathe_radius_mode> Y[#<_plane>/10]\n"
        "G18 G91 G95 S7 M3\nG0 X#<_plane> Z#<_incremental>\nG90 X#<_units_per_rev> Y#<_rpm>\n"
        "X#<_spindle_cw> Z#<_units_per_minute>\nG94\nG55 X[#<_coord_system>/100] Z#<_imperial>\n"
        "G99 M49 M5\nX#<_retract_r_plane> Y#<_retract_old_z> Z#<_feed_override>\nT2\n"
        "Y#<_selected_tool>\nM6\nX#<_current_tool>\nY#<_spindle_on> Z#<_inverse_time>\nG93 G98\n"
        "X#<_inverse_time> Y#<_retract_old_z> Z#<_ijk_absolute_mode>\nG20 X#<_imperial>\n"
        "G43 Y#<_lathe_diameter_mode>\nX#<_tool_offset>"
    ),
    "parameters that do not exist": "#<a> = 9\nG0 X EXISTS[#1] Y EXISTS[#99999] Z EXISTS[#<a>]",
    "absent axis": "G0 X1 B0\nG10 L2 P1 B0 X3\nX1\nG92 B0 X2\nX1",
    "no-ops": "G40 G49 G80\nG1 X3 F100",
    "coordinate systems": (
        "G10 L2 P2 X10 Y20 Z5 A3 C4\nG10 L2 P6 X-1\nG0 X1 Y1\nG55 X1 Y1 A1\nG1 X2 F100\n"
        "G59 G1 X3\nG53 G0 X0 Y0\nG54 X0\nG59.3 G0 X7\nG10 L20 P3 X5\nG56 G0 X6 Y1"
    ),
    "systems by parameter": (
        "G10 L2 P2 X3 Y4\nG0 X1\nG55 X1 Y1\nG1 X[#5420+1] Y[#5421+1] F100\nG54 X#5220"
    ),
    "rotation": "G10 L2 P1 R90\nG1 X20 F1000",
    "rotations": (
        "G10 L2 P1 X3 Y4 R30\nG0 X1 Y2 Z3\nG1 X5 F100\nG2 X9 Y2 I2 Z1\nG3 I-3 J1\nG3 X3 Y3 R9\n"
        "G10 L2 P2 X1 R-135\nG55 G0 X2\nG91 G1 Y3\nX1 A5\nG90 @3 ^20\nG81 X1 Y1 Z-2 R1\nG80\n"
        "G10 L2 P0 R180\nG0 X1\nG54 Y2\nG10 L2 P1 R0\nX7 Y5\nG10 L2 P1 R12 Z1\nG18 Y1"
    ),
    "rotation, calculated offsets": (
        "G0 X1 Y2\nG10 L2 P1 X3 Y4 R30\nG10 L20 P1 X5\nG0 X6\nG10 L20 P1 Y1\nG0 X1 Y7\n"
        "G10 L2 P2 R70 X1\nG10 L20 P2 X1 Y1 Z2\nG55 G0 X0 Y3 Z3"
    ),
    "rotation and ways home": (
        "G10 L2 P1 X1 R30\nG0 X1 Y1\nG28 X0\nG0 X2 Y3\nG28\nG0 X4 Y1\nG53 G0 X3 Y1\nX2 Y2\n"
        "G53 G0 Y4\nG0 X1\nG28.1\nG0 Y9\nG28 Y1"
    ),
    "rotation with tools, shifts and inches": (
        "T1 M6 G43\nG10 L2 P1 X1 R30\nG0 X2 Y1\nG92 X3 Y3\nG1 X1 F100\nG2 X3 I1\nG20 G0 X1 Y1"
    ),
    "rotation by parameter": "#5230=45\nG54 G0 X1\nG55 Y2\nG54 X2 Y#5230\nX[#5420 + 1] Y[#5421]",
    "rotation and cutter compensation": (
        "G10 L2 P1 X1 R30\nG0 X-9 Y0\nG41.1 D4 G1 X0 F100\nX20\nG3 X30 Y10 R10\nG1 Y30\nX5 Y9\n"
        "G40 G0 X0 Y0"
    ),
    "rotation and splines": "G10 L2 P1 X1 R30\nG5 X4 Y3 I1 J2 P-1 Q-1 F100\nG5.1 X9 Y1 I2 J1",
    "the end of a shift and a move": "G92 X5\nG92.1 G1 X3 F100\nG92 X5\nG92.2 X4\nG92.3 G0 X1",
    "shift": (
        "G0 X10 Y5\nG92 X1 Y1 A2\nG1 X2 F100\nG92.2\nX3\nG92.3\nX4 Y4\nG92.1\nX5\n"
        "G55 G92 X0\nG1 X1\nG10 L2 P1 X3\nG54 X1"
    ),
    "path control": "G61 G1 X1 F100\nG64 P.1 Q.02 X2\nG64\nX3\nG61.1 X4",
    "drilling": "G0 Z10\nG81 X1 Y2 Z-3 R2 F100\nX5\nY7 R1\nG99 X9\nX11 Z-4\nG98 X12\nG80\nG0 X0",
    "drilling below": "G0 Z0\nG81 X1 Z-3 R2 F100\nX2\nG80",
    "drilling with dwell": "G0 Z5\nG82 X1 Y1 Z-1 R1 P.5 F80\nX2\nX3 P.25\nG80\nG82 X4 Z-2 R1 P1",
    "pecking": "G0 Z5\nG83 X1 Y1 Z-5 R1 Q2 F80\nG99 X3\nG83 X4 Z-3 R.5 Q2.5\nG80",
    "pecking in inches": "G20 G0 Z1\nG83 X1 Y1 Z-.5 R.1 Q.2 F8\nG80",
    "chip breaking": (
        "G0 Z10\nG73 X1 Y1 Z-5 R1 Q2 F100\nX3\nG99 X5 L2\nG80 G98 G0 Z9\n"
        "G91 G73 X2 Z-3 R-1 Q.7 L2\nG90 G80\nG18 G0 Y9\nG73 X1 Y-3 Z2 R4 Q1\nX2 Q2\nG80"
    ),
    "feed before the unit of its block": "G1 X1 F100\nG20 X2 F60\nX3\nG21 X4 F90\nX5",
    "long line numbers and feeds": "N100100 G1 X1 F100000000.\nN1001000 X2",
    "boring": (
        "G0 Z10\nG85 X2 Y2 Z-3 R1 F100\nX4\nG99 X6\nG98 X7\nG89 X4 Y2 Z-3 R1 P.5\nG99 X9\nG80\n"
        "G91 G85 X1 Z-1 R1 L3\nG80 G90\nG20\nG98 G85 X1 Y1 Z-.2 R.1 F5\nG80"
    ),
    "tapping": (
        "G0 Z10\nM3 S100\nG84 X2 Y2 Z-3 R1 F100 P.2\nX4\nG99 X6 P.4\nG98 X7\nG80\n"
        "G91 G84 X1 Z-1 R1 L3 P.1\nG80 G90\nM4\nG20\nG74 X1 Y1 Z-.2 R.1 F5 P0\nX2 P.1\nG80"
    ),
    "incremental cycles": (
        "G0 X1 Y1 Z5\nG91 G81 X2 Y1 Z-3 R-1 L3 F50\nG83 Z-2 R-1 Q.5 X1 L2\nG80 G90"
    ),
    "cycles in other planes": (
        "G18 G0 X1 Y9 Z1\nG81 X2 Z3 Y-1 R2 F50\nG19 G99 G81 Y4 X-3 Z2 R1\nG80"
    ),
    "cycle after another": "G0 Z8\nG81 X1 Z0 R2 F50\nG0 Z20\nG81 X2 Z0 R2\nG82 X3 Z-1 R1 P1\nG80",
    "inverse time": "G93 G1 X10 F2\nY5 F4\nG2 X0 Y5 I-5 F1\nG94 G1 X1 F100\nG93 G1 A90 F3",
    "parameters": "#1=5 #2=[#1*2]\n#2=[#1*2]\nG0 X#1 Y#2\n#1=7 G1 X#1 F100\n#3=1\nX##3 Y-#1",
    "names": (
        "#<depth>=3 #<_global one>=4\n"
        "G0 X#<depth> Y#<_globalone> Z[EXISTS[#<depth>]+EXISTS[#<no>]]"
    ),
    "arithmetic": (
        "G0 X[1+2*3-4/2] Y[2**3**2/100] Z[7 MOD 3 - -7 MOD 3]\n"
        "X[[1+2]*[3-5]] Y[1 EQ 1 AND 2 GT 3] Z[1 OR 0 XOR 1]\n"
        "X[5 GE 5 + 1] Y[2 NE 3] Z[1 LT 2 LE 3]\nX-[3] Y[-2 ** 2] Z+[.5]"
    ),
    "functions": (
        "G0 X[ABS[-2]+SQRT[9]] Y[SIN[30]+COS[60]+TAN[45]] Z[ASIN[.5]+ACOS[.5]]\n"
        "X[ATAN[1]/[-1]] Y[EXP[1]+LN[2]] Z[FIX[-2.3]+FUP[-2.3]*10]\n"
        "X[ROUND[2.5]] Y[ROUND[-2.5]] Z[FIX[2.8]*FUP[2.2]]\nXSIN[30]YABS[-3]Z-COS[0]"
    ),
    "spindle and coolant": "S1200 M3\nM8 G1 X1 F100\nM5 M9 X2 S0\nM4 M7 S30 G0 X3\nS500",
    "polar": "G0@2^30\n@3\n^60\n@-1 Z2\nG1 F100 A5 @2^400\nG2 @2 ^0 R5\nG20 G0 @.1 ^45\nG21 @1",
    "polar, incremental": "G0X1Y1\nG91 @1\n^15\n@1^10\n@-.5 ^-40 Z1",
    "polar in shifted systems": "G10 L2 P1 X5\nG0 @1 ^90\nG92 X4\n@2 ^45\nG18 @1 ^30\nG17",
    "polar cycles": (
        "G0 X3 Y1 Z2\nG81 @2 ^10 Z-1 R1 F10\n^50\nG91 ^20 Z-2 R-1 L4\n@.5 ^5 L2\nG90 G0 X1"
    ),
    "incremental cycles behind others": (
        "G0 Z0\nG81 X1 Z-1 R1 F10\nX2\nG91 G81 X1 R1 Z-1\nX1\nG80\nG0 X1\nG99 G81 X1 R1 Z-1 L2\n"
        "X1\nG80 G90 G98"
    ),
    "pauses": "G0 X1 M0\nM1\nM60\nG1 X2 F100 M0\nX3",
    "state saved": (
        "G90 G1 X1 F100\nM70\nG0 G91 G18 G90.1 F50 X1 Y1\nG20 G99\nM72\nX3\nG1 X4\nG2 X6 I1\n"
        "G91 M70\nG90\nM72\nG0 X1\nM71\nX2"
    ),
    "system saved": "G10 L2 P2 X5 Y1\nG55\nM70\nG54 G0X1\nM72\nX1\nG64 P1 X2\nM70 G61\nM72\nX3",
    "state given back": (
        "o1 sub\nM73\nG91 G7 F7\nG1 X1\no1 endsub\no2 sub\nM73\nM71\nG91\no2 return\no2 endsub\n"
        "G90 F100\no1 call\nG1 X7\no1 call\nX9\no2 call\nX9"
    ),
    "diameters": (
        "G7 G0 X2 Z1\nX4\nG91 X2\nG90 G1 X3 F10\nG8 X3\nG18 G7 X2 Z0\nG3 X4 Z1 I0 K1\n"
        "G2 X6 Z0 R1\nG90.1 G1 X2 Z0\nG2 X4 Z1 I1 K1\nG91.1 G92 X4\nG0 X6\nG92.1\nG10 L2 P1 X4\n"
        "X6\nG10 L20 P1 X3\nX5\nG53 X4\nG28 X6\nG17 G81 X4 Z-1 R1 F10\nG91 X4 R1 Z-1 L2\n"
        "G80 G90 G8\nG0 X#5420 Y1"
    ),
    "tools": (
        "G0 Z3\nT1 M6\nG43\nG0 X1 Z1\nG43 H2 X2\nZ1\nG49 X3\nG20\nG43 H3 G1 X1 F10\nG92 Z0\nZ1\n"
        "G92.1\nG10 L20 P1 Z1\nZ3\nG53 G0 Z1\nG28\nG43 H0 X2\nT0 M6\nX1\nG43 X2"
    ),
    "tools and offsets in one block": "G0 Z5\nT1 M6 G43 H2\nG0 X1\nZ1\nT2 M6 G49 G0 X5\nZ2",
    "turns of arcs": (
        "G1 X10 F300\nG2 X0 Y-10 I-10 P2\nG3 X0 Y-10 J10 Z5 P3\nX9 Y0 R11 P2 A4\nG2 I-2 P1.00001\n"
        "G93 G3 I-3 P4 F2\nG94 F9\nG18 G2 X9 Z5 K3 P12\nX8 Z4 I-1"
    ),
    "turns of arcs, compensated": (
        "G41.1 D2 G1 X10 F300\nG2 I-10 P2\nG3 X20 Y0 I5 P3\nG40 G1 X30"
    ),
    "radii that differ": (
        "G0 X100\nG2 X-100.099 Y0 I-100 F100\nG3 X-.04 Y.3 I50.0495\nG0 X.5 Y0\n"
        "G2 X-.528 Y0 I-.5\nG0 X250\nG3 X-250.249 Y0 I-250 Z3 P2\nG20 G0 X1 Y0\nG2 X-1.0028 Y0 I-1"
    ),
    "subprograms": (
        "#1=7 #<a>=2\nM98 P100 L2\nG0 X#1 Y#<a>\nN20 M98 P#1\n/M98 P200 L0\nM98P300\nG90 Y9\nM2\n"
        "O100 (first)\nG91 G0 X1\n#1=[#1+1] #<a>=9\nM99\nN5 o9\nM98 P200\nX4\nM99\nO200\nG90 Y3\n"
        "o1 if [1]\nM99\no1 endif\nY4\nM99\nO300\nM73\nG91\nX1\no2 call [4]\nM99\n"
        "o2 sub\nG0 Z#1\no2 endsub"
    ),
    "subprogram with the end": "G0 X1\nO7\nX3\nM98 P8\nX4\nM2\nO8\nX5\nM2",
    "block delete": "/G0 X1\n / G1 Y2 F10\n/N5 X3\n/o1 if [1]\nX4\n/ o1 endif",
    "blanks in numbers": (
        "G0 X1 2. 3 Y- 4 Z .5\nG 9 1 X 1. 5\t2\nG90 X[1 2 + 3 . 5 - 1 0] Y-# 5 4 20\n"
        "# 1 = 1 2 (1 2)\nN1 0 G0 X#1 ; 3 4\nN 2 0 o1 0 if [1 1 GT 9]\nY+ 1 1\no10 endif"
    ),
    "motion words alone": "G0\nG1 F100\nX1\nG0\nX2",
    "letters in any order and case": "n10 y1 g1 f100 (comment) x 2 ; end\nx3g0z1",
}  # fmt: skip


def test_rs274__cycle_without_g98_or_g99__ends_at_the_same_height():
    assert differences("G21 G90 G0 X0 Y0 Z10\nG81 X1 Z-3 R2 F100\nX5\nG80\nG0 X9\nM2\n") == []


@pytest.mark.parametrize("name", PROGRAMS)
def test_rs274__each_feature__gives_the_same_moves(name):
    assert differences(f"{HEAD}{PROGRAMS[name]}\nM2\n") == []


REFUSED = {
    "arc off its circle": "G2 X5 Y0 I1 J3 F100",
    "radius too small": "G2 X5 R1 F100",
    "no feed": "G1 X1",
    "feed per turn without a spindle": "G95 G1 X1 F1",
    "probing per turn": "G95 M3 S9 F1\nG38.2 X1",
    "data of no tool": "G10 L1 P77 Z1",
    "data of a tool without numbers": "G10 L1 P1",
    "orientation out of range": "M19 R400",
    "direction of the orientation": "M19 R40 P3",
    "orientation without time": "M19 Q0",
    "no input": "M66",
    "two inputs": "M66 P1 E1",
    "output without a number": "M62",
    "analog output without a number": "M68 Q2",
    "cycle without R": "G81 X1 Z-1 F100",
    "cycle below R": "G81 X1 Z3 R1 F100",
    "peck without Q": "G83 X1 Z-1 R1 F100",
    "chip breaking without Q": "G73 X1 Z-1 R1 F100",
    "tap with a spindle that does not turn": "G84 X1 Z-1 R1 F100",
    "tap with a spindle that turns the other way": "M4 S100\nG84 X1 Z-1 R1 F100",
    "left tap with a spindle that turns the other way": "M3 S100\nG74 X1 Z-1 R1 F100",
    "left tap with repeats": "M4 S100\nG74 X1 Z-1 R1 L2 F100",
    "boring without P": "G89 X1 Z-1 R1 F100",
    "dwell without time": "G4",
    "shift without axes": "G92",
    "two motions": "G0 G1 X1",
    "spindle backwards by its sign": "S-5",
    "spindle both ways": "M3 M4",
    "offset out of plane": "G2 X1 K1 F100",
    "division by zero": "G0 X[1/0]",
    "root of a negative number": "G0 X[SQRT[-1]]",
    "open bracket": "G0 X[1+2",
    "name without value": "G0 X#<none>",
    "inverse time without F": "G93 G1 X1 F1\nX2",
    "thread without a pitch": "S100 M3\nG33 Z-5",
    "thread without a turning spindle": "S100\nG33 Z-5 K1",
    "thread after the spindle's stop": "S100 M3\nG33 Z-5 K1\nM5\nG33 Z5 K1",
    "thread with a feed": "S100 M3\nG33 Z-5 K1 F100",
    "thread without axes": "S100 M3\nG33 K1",
    "thread in coordinates of the machine": "S100 M3\nG53 G33 Z-5 K1",
    "thread with an offset": "S100 M3\nG33 Z-5 I1 K1",
    "probing without a feed": "G38.2 Z-5",
    "probing with inverse time": "G93 G38.2 Z-5 F3",
    "probing without axes": "G38.2 F100",
    "probing in coordinates of the machine": "G53 G38.2 Z-5 F100",
    "probing during cutter compensation": "G41.1 D3 G1 X5 F100\nG38.2 X9",
    "cycle with inverse time": "G93 G81 X1 Z-1 R1 F1",
    "machine coordinates incremental": "G91 G53 G0 X1",
    "polar at the origin": "G0 @2",
    "polar and incremental at the origin": "G91 G0 @2 ^10",
    "polar and Cartesian": "G0 @2 ^10 Y3",
    "polar shift": "G92 @2 ^10",
    "polar in the machine": "G53 G0 @2 ^10",
    "state not saved": "M72",
    "state invalid": "M70\nM71\nM72",
    "state of the caller": "o1 sub\nM72\no1 endsub\nM70\no1 call",
    "pause and end": "M0 M2",
    "radius and diameter": "G7 G8",
    "tool of no table": "T77",
    "offset of no tool": "G43 H77",
    "arc alone": "G2 F100",
    "rotation of a calculated offset": "G10 L20 P1 X1 R30",
    "offset of a rest": "G4 P1 I3",
    "radius of a shift": "G92 X1 R2",
    "offset of a shift": "G92 X1 J2",
    "offset of the way home": "G28 I1",
    "radius of the way home": "G28 X1 R1",
    "place of the way home stored": "G28.1 X1",
    "offset of the way home stored": "G28.1 K1",
    "offset of a calculated system": "G10 L20 P1 X1 I1",
    "offset of the end of a shift": "G92.1 I1",
    "radius of a line": "G1 F10 X1 R1",
    "radius of no motion": "G80 R1",
    "radius of the spindle": "M3 S5 R1",
    "offset of a tool": "G43 X1 I2 H0",
    "offset of path control": "G64 P1 K2",
    "repeats of a line": "G0 X1 L3",
    "turns, none": "G1 X10 F300\nG2 I-10 P0",
    "turns, in part": "G1 X10 F300\nG2 I-10 P1.5",
    "turns and tolerance": "G1 X10 F300\nG64 P0.1 G2 X0 Y-10 I-10",
    "radii that differ too much": "G0 X100\nG2 X-100.102 Y0 I-100 F100",
    "small radii that differ too much": "G0 X2\nG2 X-2.0284 Y0 I-2 F100",
    "radii that differ too much in inches": "G20 G0 X1\nG2 X-1.0029 Y0 I-1 F10",
    "machine coordinates of nothing": "G53",
    "feed per minute of inverse time": "G93 G1 X2 F2\nG94 X3",
    "subprogram with a move": "G0 X1 M98 P100\nM2\nO100\nM99",
    "end of a subprogram with a move": "M98 P100\nM2\nO100\nG0 X5 M99",
    "end of a subprogram with a line": "M98 P100\nM2\nO100\nG0 X5\nM99 P30",
    "no subprogram": "M98 P100",
    "subprogram without a number": "M98\nM2\nO0\nM99",
    "subprogram that is a subroutine": "o100 sub\no100 endsub\nM98 P100",
    "subroutine that is a subprogram": "o100 call\nM2\no100\nG0 X1\nM99",
    "return from a subprogram": "M98 P100\nM2\no100\no100 return\nM99",
    "block delete inside": "G0 X1 /Y2",
    "block delete after a number": "N10 /G0 X1",
    "two points in a number": "G0 X1. 2. 3",
    "rest of a cycle alone": "G82 X1 Z-1 R1 P1 F9\nP2",
}


@pytest.mark.parametrize("name", REFUSED)
def test_rs274__mistakes__are_refused_by_both(name):
    text = f"{HEAD}{REFUSED[name]}\nM2\n"
    with pytest.raises(OracleError):
        rs274(text)
    with pytest.raises(GcodeErrors):
        parse(text)


@pytest.mark.parametrize(
    "record", ["UNLOCK_ROTARY(1.0, 2.0)", "START_SPEED_FEED_SYNCH()", "STRAIGHT_PROBE (1.0)", "5"]
)
def test_rs274__record_that_is_not_known__is_seen(record):
    printed = f"    1 N..... USE_LENGTH_UNITS(CANON_UNITS_MM)\n    2 N..... {record}\n"
    ((kind, values),) = machine_records(printed, [])
    assert kind.startswith(UNKNOWN) and record in kind
    assert values == ()


def test_rs274__lines_outside_of_records__are_passed_over():
    assert list(machine_records('executing\n   1 N..... COMMENT("(x)")\n\n', [])) == []


def test_rs274__rotation_and_turns_of_an_arc__are_compared():
    text = f"{HEAD}G1 X1 F100\nM2\n"
    assert rs274(text) != rs274(text.replace("G1", "G10 L2 P1 R10\nG1"))
    arc = f"{HEAD}G2 X2 I1 F100\nM2\n"
    assert rs274(arc.replace("I1", "I1 P2")) != rs274(arc) == rs274(arc.replace("I1", "I1 P1"))


def test_rs274__one_number_changed__is_seen():
    text = f"{HEAD}G1 X1 F100\nG2 X3 I1\nM2\n"
    changed = rs274(text.replace("X3 I1", "X3.001 Y.001 I1"))
    assert any(
        abs(x - y) > 5e-4
        for a, b in zip(ours(text), changed, strict=True)
        for x, y in zip(a[1], b[1], strict=True)
    )


def test_aligned__a_move_within_the_digits_is_left_out__and_no_other():
    here, there, far = ("G0", (1.0,) * 5), ("G0", (1.0001,) * 5), ("G0", (1.01,) * 5)
    assert _aligned([here], [here, there], 1e-4) == ([here], [here])
    assert _aligned([here, there, far], [here, far], 1e-4) == ([here, far], [here, far])
    assert _aligned([here], [here, far], 1e-4) == ([here], [here, far])
    assert _aligned([here, far, here], [here, here], 1e-4)[0] == [here, far, here]


def test_feed_by_turns__is_off_by_its_digits_alone():
    printed = (
        "    1 N..... USE_LENGTH_UNITS(CANON_UNITS_MM)\n    2 N..... SET_FEED_MODE(0, 1)\n"
        "    3 N..... SET_FEED_RATE(0.1000)\n    4 N..... SET_SPINDLE_SPEED(0, 300.0000)\n"
        "    5 N..... STRAIGHT_FEED(3.0, 1.0, 1.0, 0.0, 0.0, 0.0)\n"
    )
    ((_, values),) = machine_records(printed, [])
    assert values[-1] == pytest.approx(30.0) and values[-1].miss == pytest.approx(0.015)


def test_preview__takes_its_module_from_where_rs274_is(tmp_path, monkeypatch):
    """LinuxCNC may be installed, unpacked below build, or both."""
    installed, folders = tmp_path / "usr", []
    monkeypatch.setattr(oracle, "find", lambda: installed / "bin/rs274")
    monkeypatch.setattr(oracle, "_canonical", lambda _: "NURBS_FEED")
    monkeypatch.setattr(oracle, "preview_blocks", lambda *a: folders.append(a[2]) or [])
    assert rs274("G5.1 X1 I1") == []
    assert folders == [installed / "lib/python3/dist-packages"]


@pytest.fixture(scope="module")
def samples() -> Samples:
    return compare_samples()


@pytest.mark.full
def test_samples_of_linuxcnc__read_alike_or_refused_by_name(samples):
    """Its own sample programs: none may move differently; those refused say which word it is."""
    found = samples
    assert found.different == {}
    assert set(found.equal) >= {
        *("3D_Chips.ngc", "3dtest.ngc", "arcspiral.ngc", "cds.ngc", "daisy.ngc", "flowsnake.ngc"),
        *("hole-circle.ngc", "lathe_pawn.ngc", "plasmatest.ngc", "polar.ngc", "spiral.ngc"),
        *("toplevel.ngc", "tort.ngc", "comp.ngc", "skeleton.ngc", "systems.ngc"),
        *("gmoccapy_2_tools_with_cutter_radius_compensation.ngc", "useful-subroutines.ngc"),
    }
    assert {"lathe_g7x_face_boring.ngc", "lathe_g7x_quadrants.ngc"} <= set(found.equal)
    assert {"gridprobe.ngc", "smartprobe.ngc", "threading.ngc"} <= set(found.equal)
    assert all(
        "not supported" in reason or "B, an axis" in reason for reason in found.refused.values()
    )
    total = (found.equal, found.different, found.refused, found.unfit)
    assert sum(map(len, total)) == 56


def test_samples_of_linuxcnc__with_its_sample_tools__are_those_of_the_specification(samples):
    """41 of 56 run, 24 of them with motion; without a tool table fewer would."""
    assert len(samples.equal) + len(samples.different) + len(samples.refused) == 41
    assert len(samples.moving) == 24


def test_rs274__leaves_nothing_in_the_home_folder__which_runs_at_once_would_share(
    tmp_path, monkeypatch
):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert rs274(HEAD + "G1 X1 F100\nM2")
    assert list(tmp_path.iterdir()) == []
