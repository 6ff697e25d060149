rtl/gen/absolute_regmap_pkg.sv
rtl/drive/absolute_registers.sv
rtl/drive/endat_master.sv
rtl/drive/endat_port.sv
