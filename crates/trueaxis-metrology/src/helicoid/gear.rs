//! A cylindrical helical gear by its normal module, with the resulting base cylinder and lead.

use super::{Flank, Helicoid, LONGEST_MM};
use crate::error::{InputError, Quantity};

/// A helical gear by its drawing data. Profile shift is irrelevant: it only moves the flank about z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gear {
    /// Normal module m_n, mm, above 0.
    pub module_mm: f64,
    /// Number of teeth z, 1 to 10,000.
    pub teeth: u32,
    /// Normal pressure angle α_n, degrees, between 0 and 90.
    pub pressure_angle_deg: f64,
    /// Helix angle β at the reference cylinder, degrees, between −90 and 90, not 0; positive for a right-hand helix.
    pub helix_angle_deg: f64,
}

/// Dimensions derived from a [`Gear`]; mm and degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GearData {
    /// Transverse module m_t = m_n/cos β.
    pub transverse_module_mm: f64,
    /// Transverse pressure angle, tan α_t = tan α_n/cos β.
    pub transverse_pressure_angle_deg: f64,
    /// Reference radius r = m_t z/2.
    pub reference_radius_mm: f64,
    /// Base radius r_b = r cos α_t.
    pub base_radius_mm: f64,
    /// Lead parameter p = r/tan β, mm/rad.
    pub lead_parameter_mm_per_rad: f64,
    /// Lead 2π p, mm per revolution.
    pub lead_mm: f64,
    /// Base helix angle, tan β_b = tan β cos α_t.
    pub base_helix_angle_deg: f64,
    /// Roll angle of the reference cylinder, tan α_t, rad: the u at which r² = r_b² (1 + u²).
    pub reference_roll_angle_rad: f64,
}

impl Gear {
    /// Computes the transverse data, the base cylinder and the lead.
    ///
    /// m_t = m_n/cos β, tan α_t = tan α_n/cos β, r = m_t z/2, r_b = r cos α_t, p = r/tan β.
    ///
    /// # Errors
    /// A value outside its field's stated range; β = 0 (a spur gear's flank has no lead).
    ///
    /// Source: ISO 21771:2007, clause 4.
    pub fn data(&self) -> Result<GearData, InputError> {
        let Gear { module_mm, teeth, pressure_angle_deg, helix_angle_deg } = *self;
        if !(module_mm > 0.0 && module_mm <= LONGEST_MM) {
            return Err(InputError::new(Quantity::GearModule, module_mm, "a normal module above 0 mm"));
        }
        if !(1..=10_000).contains(&teeth) {
            return Err(InputError::new(Quantity::Teeth, f64::from(teeth), "1 to 10000 teeth"));
        }
        if !(pressure_angle_deg > 0.0 && pressure_angle_deg < 90.0) {
            let needed = "a normal pressure angle between 0 and 90 degrees";
            return Err(InputError::new(Quantity::PressureAngle, pressure_angle_deg, needed));
        }
        if !(helix_angle_deg != 0.0 && helix_angle_deg.abs() < 90.0) {
            let needed = "a helix angle between -90 and 90 degrees other than 0: a spur gear's flank has no lead";
            return Err(InputError::new(Quantity::HelixAngle, helix_angle_deg, needed));
        }
        let beta = helix_angle_deg.to_radians();
        let transverse_module_mm = module_mm / libm::cos(beta);
        let tan_alpha_t = libm::tan(pressure_angle_deg.to_radians()) / libm::cos(beta);
        let reference_radius_mm = transverse_module_mm * f64::from(teeth) / 2.0;
        // cos(atan t) without computing the angle.
        let cos_alpha_t = 1.0 / libm::hypot(1.0, tan_alpha_t);
        let lead_parameter_mm_per_rad = reference_radius_mm / libm::tan(beta);
        Ok(GearData {
            transverse_module_mm,
            transverse_pressure_angle_deg: libm::atan(tan_alpha_t).to_degrees(),
            reference_radius_mm,
            base_radius_mm: reference_radius_mm * cos_alpha_t,
            lead_parameter_mm_per_rad,
            lead_mm: core::f64::consts::TAU * lead_parameter_mm_per_rad,
            base_helix_angle_deg: libm::atan(libm::tan(beta) * cos_alpha_t).to_degrees(),
            reference_roll_angle_rad: tan_alpha_t,
        })
    }

    /// Creates the flank of the gear.
    ///
    /// # Errors
    /// As [`Gear::data`] and [`Helicoid::new`].
    pub fn helicoid(&self, flank: Flank) -> Result<Helicoid, InputError> {
        let data = self.data()?;
        Helicoid::new(data.base_radius_mm, data.lead_parameter_mm_per_rad, flank)
    }
}
