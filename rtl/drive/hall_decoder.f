rtl/drive/hall_decoder.sv
