//! Places in a file where mutants can be: expressions, arms, bodies, by byte range.

use std::ops::Range;

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

pub type Bytes = Range<usize>;

#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// `a + b`, `a < b`: the operator is read from the text.
    Binary { left: Bytes, op: Bytes, right: Bytes },
    /// `a += b`.
    Assign { left: Bytes, op: Bytes, right: Bytes },
    /// `-a`, `!a`.
    Unary { op: Bytes, inner: Bytes },
    /// The body of a function, including its braces.
    Body,
    /// The pattern of an arm without a guard.
    Pattern,
    /// The guard of an arm: both the arm's mutant and the guard's.
    Guard { arm: usize },
    /// The value of a field in a struct expression with a base.
    Field { member: String, base: Bytes },
    /// The value of a constant of the file that a function can replace.
    Constant { name: String, of: String, value: Bytes },
    /// A use of a constant by name at run time.
    Use { name: String },
    /// The keyword `const` of a function.
    Const { function: String, body: Bytes },
}

/// A place; `anchor` is the start of cargo-mutants' span.
#[derive(Clone, Debug)]
pub struct Node {
    pub kind: Kind,
    pub range: Bytes,
    pub anchor: usize,
    /// Inside a constant, where no choice is possible at run time.
    pub constant: bool,
}

/// All places of a file, outer ones before inner ones.
pub fn nodes(text: &str) -> syn::Result<Vec<Node>> {
    let file = syn::parse_file(text)?;
    let mut found = Finder { text, nodes: Vec::new(), constant: false };
    found.visit_file(&file);
    let mut nodes = found.nodes;
    nodes.sort_by_key(|node| (node.range.start, std::cmp::Reverse(node.range.end)));
    Ok(nodes)
}

struct Finder<'t> {
    text: &'t str,
    nodes: Vec<Node>,
    constant: bool,
}

fn bytes(of: &impl Spanned) -> Bytes {
    of.span().byte_range()
}

/// Whether a chain of conditions contains a `let`.
fn binds(expr: &syn::Expr) -> bool {
    match expr {
        syn::Expr::Let(_) => true,
        syn::Expr::Binary(chain) => binds(&chain.left) || binds(&chain.right),
        _ => false,
    }
}

impl Finder<'_> {
    fn push(&mut self, kind: Kind, range: Bytes, anchor: usize) {
        self.nodes.push(Node { kind, range, anchor, constant: self.constant });
    }

    fn within_constant(&mut self, visit: impl FnOnce(&mut Self)) {
        let outer = std::mem::replace(&mut self.constant, true);
        visit(self);
        self.constant = outer;
    }

    fn function(&mut self, signature: &syn::Signature, block: &syn::Block) {
        let body = bytes(block);
        if let Some(word) = &signature.constness {
            let word: Span = word.span;
            let range = word.byte_range();
            let kind = Kind::Const { function: signature.ident.to_string(), body: body.clone() };
            self.push(kind, range.clone(), range.start);
        }
        self.push(Kind::Body, body.clone(), body.start);
    }
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.function(&item.sig, &item.block);
        visit::visit_item_fn(self, item);
    }
    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.function(&item.sig, &item.block);
        visit::visit_impl_item_fn(self, item);
    }
    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        if let Some(block) = &item.default {
            self.function(&item.sig, block);
        }
        visit::visit_trait_item_fn(self, item);
    }
    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        // Leave a constant unchanged if other files may use it.
        if self.constant || !matches!(item.vis, syn::Visibility::Inherited) {
            return self.within_constant(|finder| visit::visit_item_const(finder, item));
        }
        let (item_bytes, value) = (bytes(item), bytes(&*item.expr));
        let (name, of) = (item.ident.to_string(), bytes(&*item.ty));
        let of = self.text[of].to_string();
        self.push(Kind::Constant { name, of, value: value.clone() }, item_bytes.clone(), value.start);
        self.visit_expr(&item.expr);
    }
    fn visit_expr_path(&mut self, path: &'ast syn::ExprPath) {
        if let (None, Some(name)) = (&path.qself, path.path.get_ident()) {
            let range = bytes(path);
            self.push(Kind::Use { name: name.to_string() }, range.clone(), range.start);
        }
        visit::visit_expr_path(self, path);
    }
    fn visit_expr_const(&mut self, block: &'ast syn::ExprConst) {
        self.within_constant(|finder| visit::visit_expr_const(finder, block));
    }
    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.within_constant(|finder| visit::visit_impl_item_const(finder, item));
    }
    fn visit_trait_item_const(&mut self, item: &'ast syn::TraitItemConst) {
        self.within_constant(|finder| visit::visit_trait_item_const(finder, item));
    }
    fn visit_item_static(&mut self, item: &'ast syn::ItemStatic) {
        self.within_constant(|finder| visit::visit_item_static(finder, item));
    }
    fn visit_type(&mut self, item: &'ast syn::Type) {
        self.within_constant(|finder| visit::visit_type(finder, item));
    }
    fn visit_pat(&mut self, pattern: &'ast syn::Pat) {
        self.within_constant(|finder| visit::visit_pat(finder, pattern));
    }
    fn visit_generic_argument(&mut self, argument: &'ast syn::GenericArgument) {
        self.within_constant(|finder| visit::visit_generic_argument(finder, argument));
    }
    fn visit_expr_repeat(&mut self, expr: &'ast syn::ExprRepeat) {
        self.visit_expr(&expr.expr);
        self.within_constant(|finder| finder.visit_expr(&expr.len));
    }

    fn visit_expr_binary(&mut self, expr: &'ast syn::ExprBinary) {
        use syn::BinOp as B;
        let (left, op, right) = (bytes(&*expr.left), bytes(&expr.op), bytes(&*expr.right));
        let (range, anchor) = (bytes(expr), op.start);
        let assigns = matches!(
            expr.op,
            B::AddAssign(_)
                | B::SubAssign(_)
                | B::MulAssign(_)
                | B::DivAssign(_)
                | B::RemAssign(_)
                | B::BitXorAssign(_)
                | B::BitAndAssign(_)
                | B::BitOrAssign(_)
                | B::ShlAssign(_)
                | B::ShrAssign(_)
        );
        // Conditions with a `let` cannot be joined by `||`, either in the rewritten or in the original file.
        if binds(&expr.left) || binds(&expr.right) {
            return visit::visit_expr_binary(self, expr);
        }
        let kind = if assigns { Kind::Assign { left, op, right } } else { Kind::Binary { left, op, right } };
        self.push(kind, range, anchor);
        visit::visit_expr_binary(self, expr);
    }
    fn visit_expr_unary(&mut self, expr: &'ast syn::ExprUnary) {
        if !matches!(expr.op, syn::UnOp::Deref(_)) {
            let op = bytes(&expr.op);
            let anchor = op.start;
            self.push(Kind::Unary { op, inner: bytes(&*expr.expr) }, bytes(expr), anchor);
        }
        visit::visit_expr_unary(self, expr);
    }
    fn visit_arm(&mut self, arm: &'ast syn::Arm) {
        let start = bytes(arm).start;
        match &arm.guard {
            Some((_, guard)) => {
                let range = bytes(&**guard);
                self.push(Kind::Guard { arm: start }, range.clone(), range.start);
            }
            None => self.push(Kind::Pattern, bytes(&arm.pat), start),
        }
        visit::visit_arm(self, arm);
    }
    fn visit_expr_struct(&mut self, expr: &'ast syn::ExprStruct) {
        if let Some(base) = &expr.rest {
            for field in &expr.fields {
                if field.colon_token.is_some() {
                    let member = match &field.member {
                        syn::Member::Named(name) => name.to_string(),
                        syn::Member::Unnamed(index) => index.index.to_string(),
                    };
                    let kind = Kind::Field { member, base: bytes(&**base) };
                    self.push(kind, bytes(&field.expr), bytes(field).start);
                }
            }
        }
        visit::visit_expr_struct(self, expr);
    }
}
