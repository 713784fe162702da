//! Help of `trueaxis tables import` and `export`.

pub(super) const FORMATS: &str = "\
How each format stores an error E = actual − ideal:

  linuxcnc: COMP_FILE of type 0 (nominal + E, both directions) or type 1 (−E), mm and degrees. Import distinguishes \
  the types by the numbers and refuses a file that could be either; export writes type 0; --comp-file-type sets it. \
  Import needs --unit mm or inch, as the machine's LINEAR_UNITS.

  siemens: $AA_ENC_COMP, +E in one direction, mm and degrees. A file with AX1 needs --axis. Import needs --unit, and \
  also reads $AN_CEC: sag and angularity (Z over Y is EZY), one table for each direction of travel or for both.

  isg: volumetric CSV of ISG/Beckhoff, all six errors, mm and rad, rotary arguments in degrees; chain and offsets as \
  comments. Import takes a table over two or three linear axes as a grid.

  iso230-2: measured deviations, µm and µrad; one row for each approach, or one for each target with a column for \
  each run: X_mm,+1,-1,+2,-2,… or X_mm,fwd_1_um,rev_1_um,…

  columns: Position (mm),Forward,Reverse or Commanded,Reading, import only. Position, Commanded, Target, Nominal or the \
  axis; Forward and Reverse, or one of Reading, Measured, Actual. Other names: --columns position=NAME,forward=NAME and \
  ,reverse=NAME. Readings are positions or deviations, which the numbers tell. Unit in the name, as in Fwd (um): mm, um, \
  inch, deg, arcsec, urad; --unit mm, um or inch is that of readings that state none (with um, positions are in mm).

  rtl: linear measurement of Renishaw's laser software, µm, import only.

  bed-mesh: [bed_mesh NAME] of Klipper's printer.cfg, a grid over X and Y, import only. EZ = −height of the bed, \
  with the points that Klipper interpolates between the probed ones (mesh_x_pps, algo). fade_start, fade_end and \
  fade_target of [bed_mesh] (the mesh's mean unless given) become its fade. --mesh names one of several.

  heightmap: heightmap.csv of RepRapFirmware, a grid over X and Y, import only. EZ = −height. Points that were not \
  probed (0 without a decimal point) get the plane through the others, as there.

  marlin: a log with the mesh that M420 V or G29 T prints (UBL, bilinear), a grid over X and Y, import only. \
  EZ = −height. The positions are the printed corners or those of G29 V4 in the log, or --area X,Y,X,Y; Fade Height \
  becomes its fade.

  grid: X_mm,Y_mm[,Z_mm],EX_um,…,EC_urad, +E, a line for every node in any order, import only.";
