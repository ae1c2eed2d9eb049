// The papers that the methods come from. A DOI stands here only where the papers themselves print it.

const VSC = { authors: "N. Sharp, K. Crane", title: "Variational Surface Cutting", where: "ACM Transactions on Graphics 37(4), article 156, 2018", doi: "10.1145/3197517.3201356" };
const MAD = { authors: "Y. Soliman, D. Slepčev, K. Crane", title: "Optimal Cone Singularities for Conformal Flattening", where: "ACM Transactions on Graphics 37(4), article 105, 2018", doi: "10.1145/3197517.3201367" };
const PF = { authors: "J. Meny, M. Rumpf, J. Sassen", title: "A Phase-field Approach to Variational Hierarchical Surface Segmentation", where: "2021" };
const LPFB = { authors: "C. C. L. Wang", title: "Computing Length-Preserved Free Boundary for Quasi-Developable Mesh Segmentation", where: "IEEE Transactions on Visualization and Computer Graphics, 2008" };
const BFF = { authors: "R. Sawhney, K. Crane", title: "Boundary First Flattening", where: "ACM Transactions on Graphics 37(1), 2017" };
const CETM = { authors: "B. Springborn, P. Schröder, U. Pinkall", title: "Conformal Equivalence of Triangle Meshes", where: "ACM Transactions on Graphics 27(3), 2008", doi: "10.1145/1360612.1360676" };
const VSA = { authors: "D. Cohen-Steiner, P. Alliez, M. Desbrun", title: "Variational Shape Approximation", where: "SIGGRAPH 2004" };
const KT = { authors: "S. Katz, A. Tal", title: "Hierarchical Mesh Decomposition using Fuzzy Clustering and Cuts", where: "ACM Transactions on Graphics 22, 2003", doi: "10.1145/882262.882369" };

/** By method, the one that it implements first. */
export const PAPERS = {
  cutflow: [VSC, BFF],
  cones: [MAD, BFF, CETM],
  phasefield: [PF, VSC],
  developable: [LPFB, VSA, KT],
};
