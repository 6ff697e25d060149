# SPDX-License-Identifier: Apache-2.0
# Platform Designer (Qsys 13.1 and later) component of rtl/asip/asip.sv. Add this folder to the IP
# search path. The sources are those of rtl/asip/asip.f, relative to this repository. The trace ports
# belong to no interface and stay open.
package require -exact qsys 13.1

set_module_property NAME asip
set_module_property VERSION 1.0
set_module_property DISPLAY_NAME "Microtick ASIP"
set_module_property DESCRIPTION "Floating-point ASIP for control laws, one run per control tick"
set_module_property GROUP "Embedded Processors"
set_module_property INSTANTIATE_IN_SYSTEM_MODULE true
set_module_property EDITABLE false
set_module_property ANALYZE_HDL false
set_module_property ELABORATION_CALLBACK elaborate

# ---- sources
foreach kind {QUARTUS_SYNTH SIM_VERILOG} {
  add_fileset $kind $kind add_sources
  set_fileset_property $kind TOP_LEVEL asip
}

# Files of the file list in its order, which compiles packages first.
proc add_sources {entity} {
  set root [file join [get_module_property MODULE_DIRECTORY] .. ..]
  set list [open [file join $root rtl asip asip.f]]
  foreach line [split [read $list] \n] {
    set path [string trim [regsub {//.*} $line ""]]
    if {$path ne ""} {
      add_fileset_file [file tail $path] SYSTEM_VERILOG PATH [file join $root $path]
    }
  }
  close $list
}

# ---- parameters: name, default, allowed, text
foreach {name default allowed text} {
  FmaPipes  2    {1 2}                  "Multiply-add pipes"
  Slots     3    {1 3}                  "Operations per cycle: 3 with two pipes, 1 with one"
  Bundles   1024 {64 128 256 512 1024}  "Program memory [bundles]"
  DataWords 1024 {64 128 256 512 1024}  "Data memory [words]"
  Resilience 0   {0 1}                  "Every tick twice, against flipped bits (3 operations only)"
  Plausible  1   {0 1}                  "With Resilience, limits and slew of outputs 0 to 7"
  StreamWords 0  {0 256 512 1024 2048 4096 8192 16384 32768} "Constants of each multiply-add pipe [words] (3 operations only)"
  Loops      0   {0 1 2 3}              "Levels of loops without cost (3 operations only)"
  Lanes      0   {0 1 2 3}              "Lanes of each multiply-add pipe besides the first (with StreamWords)"
} {
  add_parameter $name NATURAL $default $text
  set_parameter_property $name DISPLAY_NAME $text
  set_parameter_property $name ALLOWED_RANGES $allowed
  set_parameter_property $name HDL_PARAMETER true
}

proc elaborate {} {
  set pipes [get_parameter_value FmaPipes]
  set slots [get_parameter_value Slots]
  if {$slots != 2 * $pipes - 1} {
    send_message error "FmaPipes = $pipes needs Slots = [expr {2 * $pipes - 1}], not $slots."
  }
  if {[get_parameter_value Resilience] && $slots == 1} {
    send_message error "Resilience = 1 needs Slots = 3."
  }
  if {[get_parameter_value StreamWords] && ($slots == 1 || [get_parameter_value Resilience])} {
    send_message error "StreamWords needs Slots = 3 and Resilience = 0."
  }
  if {[get_parameter_value Loops] && ($slots == 1 || [get_parameter_value Resilience])} {
    send_message error "Loops needs Slots = 3 and Resilience = 0."
  }
  if {[get_parameter_value Lanes] && ![get_parameter_value StreamWords]} {
    send_message error "Lanes needs StreamWords."
  }
}

# ---- interfaces
add_interface clock clock end
add_interface_port clock clk_i clk Input 1

add_interface reset reset end
set_interface_property reset associatedClock clock
set_interface_property reset synchronousEdges DEASSERT
add_interface_port reset rst_ni reset_n Input 1

add_interface s0 avalon end
set_interface_property s0 associatedClock clock
set_interface_property s0 associatedReset reset
set_interface_property s0 addressUnits WORDS
set_interface_property s0 bitsPerSymbol 8
set_interface_property s0 readLatency 0
set_interface_property s0 maximumPendingReadTransactions 0
set_interface_property s0 timingUnits Cycles
add_interface_port s0 address_i address Input 14
add_interface_port s0 read_i read Input 1
add_interface_port s0 write_i write Input 1
add_interface_port s0 writedata_i writedata Input 32
add_interface_port s0 readdata_o readdata Output 32
add_interface_port s0 waitrequest_o waitrequest Output 1

add_interface irq interrupt end
set_interface_property irq associatedAddressablePoint s0
set_interface_property irq associatedClock clock
set_interface_property irq associatedReset reset
add_interface_port irq irq_o irq Output 1
