; grbl style, lower case, no blanks
g21
g90
g94
g17
m3s10000
g0z5
g0x-10y0
g1z-1f100
g2x10y0i10j0f500
g2x-10y0i-10j0
g1x-10y-10
g1x10y-10
g4p0.2
g0z5
m5
m30
