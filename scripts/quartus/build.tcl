# SPDX-License-Identifier: Apache-2.0
# Area and timing of asip_de3 on Stratix III, for Quartus II 13.1:
#
#   quartus_sh -t scripts/quartus/build.tcl          from the SystemVerilog sources
#   quartus_sh -t scripts/quartus/build.tcl plain    from build/plain/quartus/asip_de3.v (microtick plain)
#   quartus_sh -t scripts/quartus/build.tcl board    also an image for the board; needs pin locations
#
# Both words may be given. The project and its reports asip_de3.{map,fit,sta}.rpt go to build/quartus.
# The sources of the ASIP are those of rtl/asip/asip.f; a tool that fails ends this script with its
# error and exit status 1.
load_package flow

set words [expr {[info exists quartus(args)] ? $quartus(args) : {}}]
foreach word $words {
    if {$word ni {plain board}} { error "unknown word '$word'; there are plain and board" }
}

set revision asip_de3
set scripts  [file dirname [file normalize [info script]]]
set root     [file dirname [file dirname $scripts]]
set folder   [file join $root build quartus]

# Lines of a file list without blank lines and comments.
proc file_list {path} {
    set channel [open $path r]
    set files {}
    foreach line [split [read $channel] "\n"] {
        set line [string trim $line]
        if {$line ne "" && ![string match "//*" $line]} { lappend files $line }
    }
    close $channel
    return $files
}

file mkdir $folder
cd $folder
project_new $revision -revision $revision -overwrite

set_global_assignment -name FAMILY "Stratix III"
set_global_assignment -name DEVICE EP3SL150F1152C2
set_global_assignment -name TOP_LEVEL_ENTITY $revision
set_global_assignment -name VERILOG_INPUT_VERSION SYSTEMVERILOG_2005
set_global_assignment -name VERILOG_MACRO "SYNTHESIS=1"
set_global_assignment -name VERILOG_MACRO "QUARTUS=1"
set_global_assignment -name SEED 1

# Worst corners of the device's commercial grade.
set_global_assignment -name NOMINAL_CORE_SUPPLY_VOLTAGE 1.1V
set_global_assignment -name MIN_CORE_JUNCTION_TEMP 0
set_global_assignment -name MAX_CORE_JUNCTION_TEMP 85
set_global_assignment -name TIMEQUEST_MULTICORNER_ANALYSIS ON
set_global_assignment -name OPTIMIZE_MULTI_CORNER_TIMING ON
set_global_assignment -name OPTIMIZE_HOLD_TIMING "ALL PATHS"

# For speed. Registers may be duplicated but not moved: area and registers stay comparable.
set_global_assignment -name OPTIMIZATION_TECHNIQUE SPEED
set_global_assignment -name FITTER_EFFORT "STANDARD FIT"
set_global_assignment -name PLACEMENT_EFFORT_MULTIPLIER 2.0
set_global_assignment -name ROUTER_TIMING_OPTIMIZATION_LEVEL MAXIMUM
set_global_assignment -name PHYSICAL_SYNTHESIS_EFFORT NORMAL
set_global_assignment -name PHYSICAL_SYNTHESIS_COMBO_LOGIC ON
set_global_assignment -name PHYSICAL_SYNTHESIS_REGISTER_DUPLICATION ON
set_global_assignment -name PHYSICAL_SYNTHESIS_REGISTER_RETIMING OFF

# Pins of the board that the design does not use are inputs with a weak pull-up.
set_global_assignment -name RESERVE_ALL_UNUSED_PINS "AS INPUT TRI-STATED WITH WEAK PULL-UP"

set board_files {
    rtl/board/board_pll.sv
    rtl/board/asip_de3.sv
}
if {"plain" in $words} {
    set plain [file join $root build/plain/quartus $revision.v]
    if {![file exists $plain]} { error "$plain is missing; run microtick plain" }
    set_global_assignment -name VERILOG_FILE $plain
} else {
    foreach file [concat [file_list [file join $root rtl/asip/asip.f]] $board_files] {
        set_global_assignment -name SYSTEMVERILOG_FILE [file join $root $file]
    }
}
set_global_assignment -name SDC_FILE [file join $scripts asip.sdc]

# Pins: real ones by name, every other port of the top is virtual. The first synthesis names them.
source [file join $scripts pins.tcl]
set real {}
foreach pin $real_pins {
    lassign $pin port location standard
    lappend real $port
    set_instance_assignment -name IO_STANDARD $standard -to $port
    if {$location ne ""} {
        set_location_assignment $location -to $port
    } elseif {"board" in $words} {
        error "$port has no location; fill it in from the board's manual in scripts/quartus/pins.tcl"
    }
}
execute_module -tool map
foreach_in_collection id [get_names -filter * -node_type pin] {
    set name [get_name_info -info full_path $id]
    if {[lsearch -exact $real $name] < 0} {
        set_instance_assignment -name VIRTUAL_PIN ON -to $name
    }
}
export_assignments

execute_module -tool map
execute_module -tool fit
execute_module -tool sta
if {"board" in $words} { execute_module -tool asm }
project_close
