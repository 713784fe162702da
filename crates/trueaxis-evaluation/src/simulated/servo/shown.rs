//! Table and plot of a bound.

use super::{LineBound, ServoBound};
use crate::shown::{Cell, Curve, Look, Plot, Shown, Table};
use trueaxis_report::number::{shortest, significant};

impl ServoBound {
    /// The bound of every line, and a plot of it.
    pub fn shown(&self) -> Shown {
        let mut notes = Vec::new();
        if let Some(drawn) = &self.drawn {
            let [low, high] = drawn.bound_over_worst.map(|ratio| significant(ratio, 3));
            notes.push(format!(
                "Of {} plants drawn with seed {} the worst reaches {} µm; the bound of a line is {low} to {high} times its \
                 worst.",
                drawn.plants,
                drawn.seed,
                significant(drawn.worst_um, 3)
            ));
        }
        let unkept = |line: &&LineBound| line.feed_for.is_some_and(|of| of.feed_per_min.is_none());
        if let (Some(wanted), count @ 1..) = (self.feed_for_um, self.lines.iter().filter(unkept).count()) {
            notes.push(format!("On {count} lines no feed was found that keeps {} µm.", shortest(wanted)));
        }
        Shown {
            title: "Contour error that the servo may leave".into(),
            summary: vec![
                self.program.clone(),
                self.machine.clone(),
                format!("{} Hz", shortest(self.servo_rate_hz)),
                format!("bound {} µm", significant(self.bound_um, 3)),
                format!("as stated {} µm", significant(self.stated_um, 3)),
                self.family.to_string(),
                format!("{} plants simulated", self.simulated_plants),
            ],
            notes,
            tables: vec![self.table()],
            plots: vec![self.plot()],
            ..Shown::default()
        }
    }

    fn table(&self) -> Table {
        let (drawn, feeds) = (self.drawn.is_some(), self.feed_for_um.is_some());
        let head = ["line", "feed per min", "as stated, µm", "bound, µm"].map(str::to_owned).into_iter();
        let head = head.chain(drawn.then(|| "worst drawn, µm".to_owned()));
        let wanted = self.feed_for_um.map(|wanted| format!("feed for {} µm", shortest(wanted)));
        let head = head.chain(wanted).chain(feeds.then(|| "bound with it, µm".to_owned()));
        let rows = self.lines.iter().map(|line| {
            let um = |value: Option<f64>| Cell::number(value, 3);
            let mut row = vec![Cell::count(line.line as usize), Cell::fixed(line.feed_per_min, 0)];
            row.extend([um(Some(line.stated_um)), um(Some(line.bound_um))]);
            row.extend(drawn.then(|| um(line.drawn_um)));
            if feeds {
                row.push(Cell::fixed(line.feed_for.and_then(|of| of.feed_per_min), 0));
                row.push(um(line.feed_for.map(|of| of.bound_um)));
            }
            row
        });
        Table::new("Contour error while cutting, line by line", head, rows.collect::<Vec<_>>())
    }

    fn plot(&self) -> Plot {
        let curve = |name: &str, colour, of: &dyn Fn(&LineBound) -> f64| {
            Curve::new(name, colour, self.lines.iter().map(of).collect())
        };
        let mut curves =
            vec![curve("bound", 4, &|line| line.bound_um), curve("figures as stated", 6, &|line| line.stated_um)];
        if self.drawn.is_some() {
            curves.push(curve("worst plant drawn", 5, &|line| line.drawn_um.unwrap_or(f64::NAN)));
        }
        Plot {
            section: "Along the program",
            title: "Contour error of every line".into(),
            x: ("line of the program".into(), ""),
            y: ("contour error", "µm"),
            look: Look::Dotted,
            caption: "Largest contour error on each line that cuts: with the machine's figures as stated, and the bound over \
                      the family of plants.",
            at: self.lines.iter().map(|line| f64::from(line.line)).collect(),
            curves,
            ..Plot::default()
        }
    }
}
