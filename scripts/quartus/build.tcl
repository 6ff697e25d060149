# SPDX-License-Identifier: Apache-2.0
# Area and timing of asip_de3 on Stratix III: quartus_sh -t scripts/quartus/build.tcl
# For Quartus II 13.1. The project and its reports asip_de3.{map,fit,sta}.rpt go to build/quartus.
# The sources of the ASIP are those of rtl/asip/asip.f; a tool that fails ends this script with its
# error and exit status 1.
load_package flow

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
set_global_assignment -name OPTIMIZATION_TECHNIQUE SPEED
set_global_assignment -name FITTER_EFFORT "STANDARD FIT"
set_global_assignment -name SEED 1

set board_files {
    rtl/board/board_pll.sv
    rtl/board/asip_de3.sv
}
foreach file [concat [file_list [file join $root rtl/asip/asip.f]] $board_files] {
    set_global_assignment -name SYSTEMVERILOG_FILE [file join $root $file]
}
set_global_assignment -name SDC_FILE [file join $scripts asip.sdc]

# Pins: real ones by name, every other port of the top is virtual. The first synthesis names them.
execute_module -tool map
source [file join $scripts pins.tcl]
set real {}
foreach pin $real_pins {
    lassign $pin port location
    lappend real $port
    if {$location ne ""} { set_location_assignment $location -to $port }
}
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
project_close
